// Linking, first part: atoms, their types and port instances. See tables.hpp.
#include "runtime/core/link/tables.hpp"

#include <algorithm>
#include <utility>

#include "bip/assert.hpp"
#include "bip/image_time.hpp"

namespace bip::rt {

// Do the tables that belong together have as many rows as what they are by? For assertions. O(connectors + ports).
static bool has_matching_sizes(const Tables& tables) {
  const Image& image = *tables.image;
  if (tables.atoms.size() != std::size_t{image.atoms.size} + 1 || tables.types.size() != image.atom_types.size)
    return false;
  if (tables.atoms.back().port_base != tables.port_atom.size()) return false;
  if (tables.connector_interactions > tables.interactions.size() || tables.atom_cells > image.cell_count) return false;
  if (!std::is_sorted(tables.port_atom.begin(), tables.port_atom.end())) return false;
  return tables.interaction_of_connector.empty() || tables.interaction_of_connector.size() == image.connectors.size;
}

Tables link(const Image& image, MaximalProgress progress) {
  Tables tables;
  tables.image = &image;
  link_atoms(tables);
  link_inner_rules(tables);
  link_interactions(tables, progress);
  link_plan_transfers(tables);
  link_network(tables);
  link_watches(tables);
  BIP_ASSERT(has_matching_sizes(tables), "{} interactions, {} ports", tables.interactions.size(),
             tables.port_atom.size());
  return tables;
}

namespace {

bool is_automaton(const AtomType& type) {
  if (type.initial.size != 1) return false;
  return std::all_of(type.transitions.begin(), type.transitions.end(),
                     [](const Transition& t) { return t.from.size == 1 && t.to.size == 1; });
}

// Without guards, internal transitions, priorities and invariants. With at most one transition for each place and port
// the type is fixed.
bool is_unguarded(const AtomType& type) {
  return type.priorities.size == 0 && type.invariants.size == 0 &&
         std::all_of(type.transitions.begin(), type.transitions.end(),
                     [](const Transition& t) { return t.guard == kNone && t.port != kNone; });
}

// Which ports of automata label how many transitions. Scratch rows are by port; each use stamps them with a number of
// its own, so they are never cleared.
class PortLabels {
 public:
  explicit PortLabels(const Tables& tables) : tables_(tables) {
    std::size_t ports = 0;
    for (const AtomType& type : tables.image->atom_types) ports = std::max<std::size_t>(ports, type.ports.size);
    stamps_.assign(ports, 0);
  }
  // Is there at most one transition for each place and port?
  bool has_one_each(const AtomType& type, const LinkedType& linked) {
    for (u32 place = 0; place < type.places.size; ++place) {
      ++stamp_;
      for (const u32 row : tables_.place_transitions[linked.first_place + place]) {
        if (!is_first(tables_.transitions[row].port)) return false;
      }
    }
    return true;
  }
  // Does each port label one transition at most?
  bool is_simple(const AtomType& type) {
    ++stamp_;
    return std::all_of(type.transitions.begin(), type.transitions.end(),
                       [&](const Transition& t) { return is_first(t.port); });
  }

 private:
  bool is_first(u32 port) { return std::exchange(stamps_[port], stamp_) != stamp_; }

  const Tables& tables_;
  std::vector<u64> stamps_;
  u64 stamp_ = 0;
};

// Does the transition leave the atom and what it offers as they are? No action, the same place, and no variables that
// the transfer of an interaction could write. An event is taken from a queue, C++ may answer otherwise next time, and
// an action beside the others or `resume` makes the atom busy.
bool is_idle(const AtomType& type, u32 row) {
  const Transition& t = type.transitions[row];
  if (t.port == kNone || t.from.size != 1 || t.to.size != 1 || t.from[0] != t.to[0] || t.action != kNone) return false;
  if (type.guards_call || type.ports[t.port].variables.size != 0) return false;
  if (type.time == nullptr) return true;
  const TransitionTime& timing = type.time->transitions[row];
  return !timing.resume.present && !timing.async.present &&
         std::none_of(type.time->events.begin(), type.time->events.end(),
                      [&](const EventPort& event) { return event.port == t.port; });
}

// For each transition of a local type the ports whose enabled transition changes for sure, and those of which guards
// say the rest. What a place offers is listed by port, so that two places are compared in one pass.
void add_deltas(Tables& tables, const AtomType& type, const LinkedType& linked) {
  const auto is_guarded = [&](u32 row) { return tables.transitions[row].source->guard != kNone; };
  const auto port_of = [&](u32 row) { return tables.transitions[row].port; };
  std::vector<std::vector<u32>> offered(type.places.size);
  for (u32 place = 0; place < type.places.size; ++place) {
    const Span<u32> rows = tables.place_transitions[linked.first_place + place];
    offered[place].assign(rows.begin(), rows.end());
    std::sort(offered[place].begin(), offered[place].end(), [&](u32 a, u32 b) { return port_of(a) < port_of(b); });
  }
  for (u32 i = 0; i < linked.transition_count; ++i) {
    LinkedTransition& t = tables.transitions[linked.first_transition + i];
    const std::vector<u32>& now = offered[t.to];
    t.delta_first = static_cast<u32>(tables.deltas.size());
    t.guarded_first = static_cast<u32>(tables.guarded_ports.size());
    if (t.from != t.to) {
      auto next = now.begin();
      const auto gains = [&](u32 row) {
        if (!is_guarded(row)) tables.deltas.push_back({port_of(row), row});
      };
      for (const u32 row : offered[t.from]) {
        const u32 port = port_of(row);
        for (; next != now.end() && port_of(*next) < port; ++next) gains(*next);
        if (next != now.end() && port_of(*next) == port) gains(*next++);
        else tables.deltas.push_back({port, kNone});
      }
      for (; next != now.end(); ++next) gains(*next);
    }
    for (const u32 row : now) {
      if (is_guarded(row)) tables.guarded_ports.push_back({tables.transitions[row].guard, port_of(row), row});
    }
    t.delta_count = static_cast<u32>(tables.deltas.size()) - t.delta_first;
    t.guarded_count = static_cast<u32>(tables.guarded_ports.size()) - t.guarded_first;
    if (t.settling == Settling::All) t.settling = linked.simple ? Settling::Flips : Settling::Rows;
  }
}

// Ports of which all transitions leave the atom as it is.
std::vector<u32> idle_ports(const Tables& tables, const AtomType& type, const LinkedType& linked) {
  std::vector<u32> idle;
  if (linked.is_timed) return idle;
  std::vector<bool> is_idle(type.ports.size, true);
  for (u32 i = 0; i < linked.transition_count; ++i) {
    const LinkedTransition& t = tables.transitions[linked.first_transition + i];
    if (t.port != kNone && !t.is_idle) is_idle[t.port] = false;
  }
  for (u32 port = 0; port < type.ports.size; ++port) {
    if (is_idle[port]) idle.push_back(port);
  }
  return idle;
}

void link_idle_ports(Tables& tables) {
  const Image& image = *tables.image;
  std::vector<std::vector<u32>> idle;
  for (u32 row = 0; row < image.atom_types.size; ++row)
    idle.push_back(idle_ports(tables, image.atom_types[row], tables.types[row]));
  if (std::all_of(idle.begin(), idle.end(), [](const auto& ports) { return ports.empty(); })) return;
  tables.idle_ports.assign((tables.port_atom.size() + 63) / 64, 0);
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    for (const u32 port : idle[tables.atoms[atom].type]) {
      const u32 instance = tables.instance(atom, port);
      tables.idle_ports[instance >> 6] |= u64{1} << (instance & 63);
    }
  }
}

}  // namespace

void link_atoms(Tables& tables) {
  const Image& image = *tables.image;
  std::vector<Csr::Pair> labelled, internal;
  u32 places = 0;
  std::size_t transitions = 0;
  for (const AtomType& type : image.atom_types) transitions += type.transitions.size;
  tables.transitions.reserve(transitions);
  labelled.reserve(transitions);
  tables.types.reserve(image.atom_types.size);
  for (const AtomType& type : image.atom_types) {
    LinkedType linked;
    linked.first_transition = static_cast<u32>(tables.transitions.size());
    linked.transition_count = type.transitions.size;
    linked.first_place = places;
    places += type.places.size;
    const bool automaton = is_automaton(type);
    linked.mark_words = automaton ? 0 : (type.places.size + 63) / 64;
    linked.is_timed = type.time != nullptr;
    BIP_ASSERT(!automaton || type.initial[0] < type.places.size, "place {} of {}", type.initial[0], type.places.size);
    linked.has_priorities = type.priorities.size != 0;
    linked.has_invariants = type.invariants.size != 0;
    linked.initial = tables.code(type.initial_action);
    for (u32 k = 0; k < type.transitions.size; ++k) {
      const Transition& t = type.transitions[k];
      linked.has_internal |= t.port == kNone;
      const u32 row = static_cast<u32>(tables.transitions.size());
      const bool is_still = automaton && is_idle(type, k);
      tables.transitions.push_back({tables.code(t.guard), tables.code(t.action), t.port, automaton ? t.from[0] : kNone,
                                    automaton ? t.to[0] : kNone, 0, 0, 0, 0, &t,
                                    is_still && type.time == nullptr ? Settling::Nothing : Settling::All, is_still});
      if (automaton) (t.port == kNone ? internal : labelled).push_back({linked.first_place + t.from[0], row});
    }
    tables.types.push_back(linked);
  }
  tables.place_transitions = Csr::build(places, labelled);
  tables.place_internals = Csr::build(places, internal);
  PortLabels labels(tables);
  for (u32 i = 0; i < image.atom_types.size; ++i) {
    const AtomType& type = image.atom_types[i];
    LinkedType& linked = tables.types[i];
    linked.one_each = linked.mark_words == 0 && labels.has_one_each(type, linked);
    linked.fixed = linked.one_each && !linked.is_timed && is_unguarded(type);
    linked.simple = linked.fixed && labels.is_simple(type);
    linked.is_local =
        linked.one_each && !linked.is_timed && !linked.has_internal && !linked.has_invariants && !linked.has_priorities;
    if (linked.is_local) add_deltas(tables, type, linked);
  }

  std::size_t ports = 0;
  for (const Atom& atom : image.atoms) ports += image.atom_types[atom.type].ports.size;
  tables.port_atom.reserve(ports);
  tables.atoms.reserve(std::size_t{image.atoms.size} + 1);
  if (std::any_of(tables.types.begin(), tables.types.end(),
                  [](const LinkedType& type) { return type.mark_words != 0; }))
    tables.mark_base.resize(image.atoms.size);
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    const Atom row = image.atoms[atom];
    const AtomType& type = image.atom_types[row.type];
    BIP_ASSERT(row.first_cell + type.variables.size <= image.cell_count, "atom {} has data from cell {} on, of {}",
               atom, row.first_cell, image.cell_count);
    tables.atoms.push_back({static_cast<u32>(tables.port_atom.size()), row.variable(0), row.type, 0});
    tables.port_atom.insert(tables.port_atom.end(), type.ports.size, atom);
    if (!tables.mark_base.empty()) tables.mark_base[atom] = tables.mark_words;
    tables.mark_words += tables.types[row.type].mark_words;
    tables.atom_cells = std::max(tables.atom_cells, row.first_cell + type.variables.size);
  }
  tables.atoms.push_back({static_cast<u32>(tables.port_atom.size()), {}, 0, 0});
  link_idle_ports(tables);
}

void Binds::make(const Image& image) {
  if (rows != nullptr || image.binds.size == 0) return;
  if (image.choices.size == 0 && image.binds.repeats.size == 0) {
    rows = &image.binds.rows.data->cell;
    return;
  }
  own.reserve(image.binds.size);
  BIP_ASSERT(own.empty(), "{} bound variables were listed before", own.size());
  for (const Bind& bind : image.binds) own.push_back(bind.cell);
  rows = own.data();
}

u32 Tables::clause_of(u32 connector_type_row, Span<u32> params) const {
  const ConnectorType& type = image->connector_types[connector_type_row];
  const Span<u32> order = clause_order[connector_type_row];
  BIP_ASSERT(std::is_sorted(params.begin(), params.end()), "{} parameters are not in order", params.size);
  // Among few, by looking at each.
  constexpr std::size_t kFew = 8;
  if (order.size <= kFew) {
    for (const u32 row : order) {
      const Span<u32>& other = type.clauses[row].params;
      if (other.size == params.size && std::equal(params.begin(), params.end(), other.begin())) return row;
    }
    return kNone;
  }
  const auto less = [](Span<u32> a, Span<u32> b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  };
  const auto found = std::lower_bound(order.begin(), order.end(), params,
                                      [&](u32 row, Span<u32> key) { return less(type.clauses[row].params, key); });
  if (found == order.end() || less(params, type.clauses[*found].params)) return kNone;
  return *found;
}

}  // namespace bip::rt
