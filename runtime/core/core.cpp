// The core's life outside of steps: construction, the initial state, snapshot and restore, looking at candidates.
#include "runtime/core/core.hpp"

#include <algorithm>
#include <cstring>

namespace bip::rt {

Core::Core(const Image& image, CoreOptions options)
    : tables_(link(image, options.progress)), options_(options), rules_(link_priorities(tables_)), ffi_data_(image) {
  const u32 cell_count = static_cast<u32>(tables_.interactions.size());
  atoms_ = {tables_.atoms.data(), image.atoms.size};
  all_.assign(image.cell_count, Cell{0});
  for (u32 i = 0; !ffi_data_.empty() && i < image.connectors.size; ++i) zero_frame(i);
  ports_.resize(tables_.port_atom.size());
  const auto is_direct = [&](u32 interaction) {
    return !tables_.interactions[interaction].searched && (rules_.count == 0 || rules_.is_involved[interaction] == 0);
  };
  while (direct_.below < cell_count && is_direct(direct_.below)) ++direct_.below;
  if (direct_.below != cell_count) {
    for (u32 i = 0; i < cell_count; ++i) direct_.is_direct.push_back(is_direct(i) ? 1 : 0);
    is_dirty_.assign(cell_count, 0);
  }
  listing_of_.assign(tables_.any_searched ? cell_count : 0, kNone);
  for (u32 i = 0; tables_.any_searched && i < cell_count; ++i) {
    const InteractionInfo info = tables_.interactions[i];
    if (!info.searched) continue;
    listing_of_[i] = static_cast<u32>(listings_.size());
    listings_.emplace_back();
    flat_guards_.push_back(flat_guard(info));
    is_weighted_ |= info.kind != InteractionKind::Flat;
  }
  u32 ports = 0, nodes = 0, uses = 0;
  for (const AtomType& type : image.atom_types) ports = std::max(ports, type.ports.size);
  for (const Plan& plan : tables_.plans) {
    nodes = std::max(nodes, plan.node_count);
    uses = std::max(uses, plan.use_count);
  }
  port_scratch_.assign(ports, kNone);
  available_.assign(nodes, 0);
  chosen_.assign(nodes, 0);
  node_scratch_.assign(nodes, 0);
  use_clause_.assign(uses, kNone);
  build_time();
  if (looks_at_binds()) binds_.make(image);
  forget();
  link_steps();
}

FlatGuard Core::flat_guard(const InteractionInfo& info) {
  if (info.kind != InteractionKind::Flat || info.clause() == kNone || !ffi_data_.empty()) return {};
  const Clause& clause = tables_.connector_type(info.row).clauses[info.clause()];
  const Code guard = tables_.code(clause.guard);
  if (guard.fn == nullptr || clause.may_fault) return {};
  const Connector& row = tables_.image->connectors[info.row];
  return {code_row(guard, tables_.connector_type(info.row).variables.size), row.first_cell, row.binds};
}

// To no state at all: no atom is anywhere, no port enabled.
void Core::forget() {
  const u32 cell_count = static_cast<u32>(tables_.interactions.size());
  places_.assign(atoms_.size, kNone);
  history_.assign(kHistory, kNone);
  history_at_ = 0;
  marks_.assign(tables_.mark_words, 0);
  for (u32 i = 0; i < ports_.size(); ++i) {
    const u32 atom = tables_.port_atom[i];
    const LinkedType& type = tables_.types[atoms_[atom].type];
    ports_[i].transition = ports_[i].place = kNone;
    if (!type.simple) continue;
    for (u32 row = type.first_transition; row < type.first_transition + type.transition_count; ++row) {
      if (tables_.transitions[row].port != i - tables_.port_base(atom)) continue;
      ports_[i].transition = row;
      ports_[i].place = tables_.transitions[row].from;
    }
  }
  values_.resize(tables_.node_count());
  for (u32 interaction = 0; interaction < cell_count; ++interaction)
    values_[interaction] = tables_.start_of(interaction);
  std::copy(tables_.inner_start.begin(), tables_.inner_start.end(), values_.begin() + cell_count);
  if (time_ != nullptr) forget_time();
  enabled_.reset(cell_count, is_weighted_);
  for (Listing& listing : listings_) listing = {};
  dirty_.clear();
  std::fill(is_dirty_.begin(), is_dirty_.end(), std::uint8_t{0});
  crossings_.clear();
  rule_states_.assign(rules_.count, {});
  contributions_.assign(rules_.high_edges.size(), 0);
  dirty_rules_.clear();
  for (u32 i = 0; i < rules_.count; ++i) dirty_rules_.push_back(i);
  is_rule_dirty_.assign(rules_.count, 1);
  changed_components_.clear();
  is_component_changed_.assign(rules_.cyclic.size(), 0);
  reweigh_.clear();
  is_reweighed_.assign(rules_.count == 0 ? 0 : cell_count, 0);
}

bool Core::initialize() {
  const Image& image = *tables_.image;
  fault_ = {};
  forget();
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    const AtomType& type = tables_.atom_type(atom);
    const LinkedType& linked = tables_.types[atoms_[atom].type];
    const AtomInfo& state = atoms_[atom];
    Cell* interactions = all_.data() + state.first_cell;
    u32 args = image.atoms[atom].args;
    for (u32 i = 0; i < type.variables.size; ++i) {
      interactions[i] = Cell{0};
      if (type.variables[i].is_param) interactions[i] = image.args[args++];
    }
    if (!ffi_data_.empty()) ffi_data_.reset(type.variables, all_.data(), state.first_cell);
    if (linked.mark_words == 0) {
      places_[atom] = type.initial[0];
    } else {
      places_[atom] = 0;
      u64* marks = marks_.data() + tables_.first_mark(atom);
      for (u32 place : type.initial) marks[place >> 6] |= u64{1} << (place & 63);
    }
    if (time_ != nullptr) start_clocks(atom);
    if (linked.initial.fn != nullptr) {
      const std::int32_t status = linked.initial.fn(linked.initial.context, interactions, all_.data(), nullptr);
      if (status >= 2) return fail_code(status, atom, kNone, nullptr);
    }
    if (time_ != nullptr && !read_clocks(atom, nullptr)) return false;
    if (linked.has_invariants && !check_invariants(atom, nullptr)) return false;
    if (!settle_atom(atom, kNone, nullptr)) return false;
    if (state.watched != 0) touch(atom);
  }
  return settle_anew();
}

// The list of the uniform policy starts from the order of candidates.
bool Core::settle_anew() {
  enabled_.unlist();
  if (!settle()) return false;
  if (keeps_list_) enabled_.list(static_cast<u32>(tables_.interactions.size()));
  return true;
}

void Core::keep_list() {
  keeps_list_ = true;
  enabled_.list(static_cast<u32>(tables_.interactions.size()));
}

std::vector<u32> Core::list_order() const {
  std::vector<u32> order;
  for (u32 i = 0; keeps_list_ && i < enabled_.listed_count(); ++i) order.push_back(enabled_.listed(i));
  return order;
}

void Core::set_list_order(const std::vector<u32>& order) {
  if (keeps_list_) enabled_.list(order, static_cast<u32>(tables_.interactions.size()));
}

Candidate Core::candidate(EnabledSet::Position at) const {
  Candidate candidate;
  candidate.interaction = at.interaction;
  if (at.interaction >= tables_.connector_interactions) {
    const u32 instance = tables_.interactions[at.interaction].row;
    candidate.atom = tables_.port_atom[instance];
    candidate.port = instance - tables_.port_base(candidate.atom);
    return candidate;
  }
  candidate.connector = tables_.connector_of(at.interaction);
  candidate.config = at.rank;
  const u32 listing = listing_of(at.interaction);
  if (listing == kNone) return candidate;
  const std::vector<std::uint8_t>& hidden = listings_[listing].hidden;
  if (hidden.empty()) return candidate;
  u32 left = at.rank;
  for (candidate.config = 0; hidden[candidate.config] != 0 || left-- > 0;) ++candidate.config;
  return candidate;
}

std::uint64_t Core::next_after(u32 interaction) const {
  const std::uint64_t k = enabled_.rank(interaction + 1);
  return k < enabled_.total() ? k : 0;
}

State Core::snapshot() const {
  State state;
  state.places = places_;
  state.marks = marks_;
  state.data.resize(tables_.atom_cells);
  if (!state.data.empty()) std::memcpy(state.data.data(), all_.data(), state.data.size() * sizeof(Cell));
  ffi_data_.save(state.data, state.objects);
  if (time_ != nullptr) save_time(state.time);
  return state;
}

bool Core::restore(const State& state) {
  const Image& image = *tables_.image;
  enabled_.unlist();
  // A fault leaves things between two states.
  if (fault_) forget();
  fault_ = {};
  if (time_ != nullptr) load_time(state.time);
  // All objects first: what an atom offers may depend on them. An atom that has one counts as changed.
  if (!ffi_data_.empty()) ffi_data_.load(all_.data(), state.objects);
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    const AtomInfo& now = atoms_[atom];
    const AtomType& type = image.atom_types[now.type];
    const u32 interactions = type.variables.size;
    const u32 words = tables_.types[now.type].mark_words;
    const u32 mark = tables_.first_mark(atom);
    const bool same_data = interactions == 0 || std::memcmp(&all_[now.first_cell], &state.data[now.first_cell],
                                                            interactions * sizeof(Cell)) == 0;
    const bool same_marks = words == 0 || std::memcmp(&marks_[mark], &state.marks[mark], words * sizeof(u64)) == 0;
    // What a timed atom offers depends on the instant.
    const bool is_still = time_ == nullptr || type.time == nullptr;
    if (is_still && same_data && same_marks && places_[atom] == state.places[atom]) continue;
    for (u32 i = 0; i < interactions; ++i) {
      if (!is_ffi(type.variables[i].type)) all_[now.first_cell + i].bits = state.data[now.first_cell + i];
    }
    if (words != 0) std::memcpy(&marks_[mark], &state.marks[mark], words * sizeof(u64));
    const u32 before = places_[atom];
    places_[atom] = state.places[atom];
    if (!update_ports(atom, before)) return false;
    if (now.watched != 0) touch(atom);
  }
  if (has_async()) restart_jobs();
  return settle_anew();
}

bool Core::is_marked(u32 atom, u32 place) const {
  if (tables_.types[atoms_[atom].type].mark_words == 0) return places_[atom] == place;
  return (marks_[tables_.first_mark(atom) + (place >> 6)] >> (place & 63) & 1) != 0;
}

u32 Core::enabled_transition(u32 atom, u32 port) const {
  const u32 row = enabled_row(tables_.port_base(atom) + port);
  return row == kNone ? kNone : row - tables_.types[atoms_[atom].type].first_transition;
}

std::vector<u32> Core::last_interactions() const {
  std::vector<u32> last(atoms_.size, kNone);
  for (u32 i = 0; i < kHistory; ++i) {
    const u32 interaction = history_[(history_at_ + i) % kHistory];
    if (interaction == kNone) continue;
    const InteractionInfo info = tables_.interactions[interaction];
    if (info.kind == InteractionKind::Port) last[tables_.port_atom[info.row]] = interaction;
    for (u32 port = 0; port < info.count; ++port)
      last[tables_.port_atom[tables_.flat_ports[info.first + port]]] = interaction;
    if (info.plan() == kNone) continue;
    const Plan& plan = tables_.plans[info.plan()];
    for (u32 node = plan.first_node; node < plan.first_node + plan.node_count; ++node) {
      if (tables_.plan_nodes[node].kind == NodeKind::Leaf)
        last[tables_.port_atom[tables_.plan_nodes[node].ref]] = interaction;
    }
  }
  return last;
}

std::vector<u32> Core::recent_interactions(u64 count) const {
  std::vector<u32> interactions;
  for (u64 i = count; i > 0; --i) interactions.push_back(history_[(history_at_ + kHistory - i) % kHistory]);
  return interactions;
}

u32 Core::listed_count(u32 connector) const {
  const u32 interaction = tables_.interaction_of(connector);
  if (interaction == kNone) return 0;
  // Compiled steps keep the list of the enabled alone.
  return rules_.count == 0 ? enabled_.weight(interaction) : base_count(interaction);
}

}  // namespace bip::rt
