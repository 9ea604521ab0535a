// See net_encoding.hpp.
#include "compiler/verify/net/net_encoding.hpp"

#include <algorithm>
#include <numeric>

#include "compiler/system/system.hpp"
#include "compiler/verify/invariants/weighted_sum.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {
// Combinations of modes for which a connector's guard is evaluated.
constexpr std::size_t kMaxCombinations = 4096;
}  // namespace

Encoding::Encoding(const Net& net, const ModeReachability& reachable, Encoded what)
    : net_(net), reachable_(reachable), guards_(net.system->code, solver_) {
  BIP_ASSERT(net.too_large_atom == kNoRow, "atom {} has too many modes", net.too_large_atom);
  add_atoms();
  if (what == Encoded::Nothing) return;
  add_no_end();
  lacking_.resize(net.graph.nodes.size());
  for (u32 row = 0; row < net.graph.nodes.size(); ++row) {
    const Node& node = net.graph.nodes[row];
    if (node.kind == ConnectorNodeKind::Port) {
      lacking_[row] = port(row);
    } else {
      bool has_guards = false;
      if (node.connector != kNoRow) {
        const System& system = *net.system;
        const ConnectorType& type =
            system.connector_types[system.connectors[ConnectorId(std::size_t{node.connector})].type];
        has_guards = std::any_of(type.clauses.begin(), type.clauses.end(),
                                 [&](const Clause& clause) { return !is_always_true(system.code, clause.guard); });
      }
      lacking_[row] = has_guards ? guarded(row) : group(row);
      if (has_guards && node.is_root) add_guarded_rendezvous(row);
    }
    if (node.is_root) add_step(lacking_[row]);
  }
}

void Encoding::add_atoms() {
  marked_.assign(net_.mode_count(), 0);
  std::vector<Lit> modes;
  for (u32 atom = 0; atom + 1 < net_.mode_base.size(); ++atom) {
    modes.clear();
    for (u32 mode = net_.mode_base[atom]; mode < net_.mode_base[atom + 1]; ++mode) {
      if (!reachable_.is_on(mode)) continue;
      marked_[mode] = solver_.new_variable();
      modes.push_back(marked_[mode]);
    }
    solver_.add(modes);
    add_at_most_one(solver_, modes);
  }
  for (Lit literal : marked_) is_reachable_.push_back(literal != 0 ? 1 : 0);
}

// Final states are no deadlocks.
void Encoding::add_no_end() {
  std::vector<Lit> modes;
  for (u32 atom = 0; atom + 1 < net_.mode_base.size(); ++atom) {
    const ModeClass& row = net_.class_at(atom);
    const std::vector<std::uint32_t>& finals = net_.system->atom_types[row.type].final_places;
    if (finals.empty()) return;
    for (u32 mode = net_.mode_base[atom]; mode < net_.mode_base[atom + 1]; ++mode) {
      const std::vector<std::uint32_t>& places = row.modes[mode - net_.mode_base[atom]].places;
      if (marked_[mode] != 0 && !std::includes(finals.begin(), finals.end(), places.begin(), places.end()))
        modes.push_back(marked_[mode]);
    }
  }
  solver_.add(modes);
}

// Is it a use of a port, told apart from the others?
bool Encoding::is_use(u32 row) const {
  const u32 atom = net_.graph.atom_of_port[row];
  return row - net_.graph.port_base[atom] >= net_.class_at(atom).is_sure.size();
}

// Modes of the class from which the port may move, sorted.
std::vector<u32> Encoding::sources_of_moves(u32 row) const {
  std::vector<u32> modes;
  for (const Move& move : net_.moves(row)) {
    if (modes.empty() || modes.back() != move.from) modes.push_back(move.from);
  }
  return modes;
}

Encoding::Lacking Encoding::port(u32 row) {
  const u32 atom = net_.graph.atom_of_port[row];
  const u32 base = net_.mode_base[atom];
  const ModeClass& of_atom = net_.class_at(atom);
  const u32 port = of_atom.port_of(row - net_.graph.port_base[atom]);
  const AtomType& type = net_.system->atom_types[of_atom.type];
  const std::vector<std::uint8_t>& is_sure = of_atom.is_sure[port];
  const auto locate = [&](const Expr& e) { return std::optional(GuardLiterals::Place{atom, e.index}); };
  std::vector<Lit> sure;
  std::vector<std::pair<Lit, Lit>> guarded;  // in this mode, with this guard
  bool ever_unsure = false;
  // Inside an atom with priorities a port whose guard is true may be hidden.
  std::vector<const Transition*> with_guard;
  if (type.priorities.empty()) {
    for (const Transition& t : type.transitions)
      if (t.port == port && t.guard.is_valid()) with_guard.push_back(&t);
  }
  // Of a use that is told apart only where its guard may be true.
  std::vector<u32> modes = is_use(row) ? sources_of_moves(row) : std::vector<u32>(is_sure.size());
  if (is_use(row)) ever_unsure = true;
  else std::iota(modes.begin(), modes.end(), 0);
  for (u32 mode : modes) {
    if (!reachable_.is_on(base + mode)) continue;
    BIP_ASSERT(marked_[base + mode] != 0, "mode {} is reachable and has no variable", base + mode);
    if (is_sure[mode] != 0) {
      sure.push_back(marked_[base + mode]);
      continue;
    }
    ever_unsure = true;
    const std::vector<u32>& places = of_atom.modes[mode].places;
    for (const Transition* t : with_guard) {
      if (!std::all_of(t->from.begin(), t->from.end(),
                       [&](u32 place) { return std::binary_search(places.begin(), places.end(), place); }))
        continue;
      if (evaluate(net_.system->code, t->guard, of_atom.modes[mode].values, {}).is_known) continue;
      if (const std::optional<Lit> guard = guards_.literal(t->guard, locate))
        guarded.emplace_back(marked_[base + mode], *guard);
    }
  }
  if (sure.empty() && guarded.empty()) return {Lacking::Kind::Always, 0};
  if (!ever_unsure) return {Lacking::Kind::Never, 0};
  if (sure.size() == 1 && guarded.empty()) return {Lacking::Kind::Literal, -sure[0]};
  const Lit lacking = solver_.new_variable();
  for (Lit literal : sure) solver_.add({-lacking, -literal});
  for (const auto& [mode, guard] : guarded) solver_.add({-lacking, -mode, -guard});
  return {Lacking::Kind::Literal, lacking};
}

// A node that needs all of these lacks something if one of them does.
Encoding::Lacking Encoding::all_of(const std::vector<u32>& children) {
  BIP_ASSERT(!children.empty(), "a rendezvous of nothing");
  std::vector<Lit> clause;
  for (u32 child : children) {
    const Lacking& below = lacking_[child];
    if (below.kind == Lacking::Kind::Always) return below;
    if (below.kind == Lacking::Kind::Literal) clause.push_back(below.literal);
  }
  if (clause.empty()) return {Lacking::Kind::Never, 0};
  if (clause.size() == 1) return {Lacking::Kind::Literal, clause[0]};
  const Lit lacking = solver_.new_variable();
  clause.push_back(-lacking);
  solver_.add(clause);
  return {Lacking::Kind::Literal, lacking};
}

Encoding::Lacking Encoding::any_of(const std::vector<u32>& children) {
  std::vector<Lit> parts;
  for (u32 child : children) {
    const Lacking& below = lacking_[child];
    if (below.kind == Lacking::Kind::Never) return below;
    if (below.kind == Lacking::Kind::Literal) parts.push_back(below.literal);
  }
  if (parts.empty()) return {Lacking::Kind::Always, 0};
  if (parts.size() == 1) return {Lacking::Kind::Literal, parts[0]};
  const Lit lacking = solver_.new_variable();
  for (Lit part : parts) solver_.add({-lacking, part});
  return {Lacking::Kind::Literal, lacking};
}

Encoding::Lacking Encoding::group(u32 row) {
  std::vector<u32> children;
  for (const Edge& child : net_.graph.children(row)) {
    if (net_.graph.nodes[row].kind != ConnectorNodeKind::Trigger || child.is_trigger) children.push_back(child.node);
  }
  return net_.graph.nodes[row].kind == ConnectorNodeKind::All ? all_of(children) : any_of(children);
}

// A connector with guards: a rendezvous of atoms with its guard's literal; else sure are only its interactions of one
// trigger alone whose clause has no guard.
Encoding::Lacking Encoding::guarded(u32 row) {
  if (is_guarded_rendezvous(row)) return rendezvous(row);
  const System& system = *net_.system;
  const Connector& connector = system.connectors[ConnectorId(std::size_t{net_.graph.nodes[row].connector})];
  const ConnectorType& type = system.connector_types[connector.type];
  std::vector<u32> children;
  const std::span<const Edge> edges = net_.graph.children(row);
  for (std::size_t k = 0; k < edges.size() && net_.graph.nodes[row].kind == ConnectorNodeKind::Trigger; ++k) {
    const DefineNode& leaf = type.define[type.define[0].children[k]];
    if (!edges[k].is_trigger || !leaf.is_leaf) continue;
    const std::vector<u32> alone{leaf.param};
    const bool has_guard = std::any_of(type.clauses.begin(), type.clauses.end(), [&](const Clause& clause) {
      return clause.params == alone && !is_always_true(system.code, clause.guard);
    });
    if (!has_guard) children.push_back(edges[k].node);
  }
  return any_of(children);
}

bool Encoding::is_guarded_rendezvous(u32 row) const {
  const Connector& connector = net_.system->connectors[ConnectorId(std::size_t{net_.graph.nodes[row].connector})];
  const ConnectorType& type = net_.system->connector_types[connector.type];
  if (net_.graph.nodes[row].kind != ConnectorNodeKind::All || type.clauses.size() != 1 ||
      type.clauses[0].params.size() != type.params.size())
    return false;
  if (std::any_of(connector.ports.begin(), connector.ports.end(),
                  [](const PortRef& ref) { return ref.kind != PortRef::Kind::Atom; }))
    return false;
  return std::all_of(type.define.begin(), type.define.end(), [&](const DefineNode& node) {
    return std::none_of(node.children.begin(), node.children.end(),
                        [&](u32 child) { return type.define[child].trigger; });
  });
}

// Which variable of which atom each Bind variable of a rendezvous of atoms is.
std::vector<GuardLiterals::Place> Encoding::sources_of(u32 row) const {
  const System& system = *net_.system;
  const Connector& connector = system.connectors[ConnectorId(std::size_t{net_.graph.nodes[row].connector})];
  const ConnectorType& type = system.connector_types[connector.type];
  std::vector<GuardLiterals::Place> sources;
  for (std::size_t p = 0; p < type.params.size(); ++p) {
    const PortRef& ref = connector.ports[p];
    const Port& atom_port = system.atom_types[system.atoms[ref.atom].type].ports[ref.port];
    sources.resize(std::max<std::size_t>(sources.size(), type.params[p].first_bind + atom_port.variables.size()));
    for (std::size_t v = 0; v < atom_port.variables.size(); ++v)
      sources[type.params[p].first_bind + v] = {ref.atom.value, atom_port.variables[v]};
  }
  BIP_ASSERT(connector.data.size() == type.data_reads.size(), "{} of {} data that the connector reads",
             connector.data.size(), type.data_reads.size());
  sources.resize(type.bind_count(system.port_types) - type.data_reads.size());
  for (const DataRef& ref : connector.data) sources.push_back({ref.atom.value, ref.variable});
  return sources;
}

// Available if all parts are and the guard is true; an `up` might change what the guard reads.
Encoding::Lacking Encoding::rendezvous(u32 row) {
  const System& system = *net_.system;
  const ConnectorType& type =
      system.connector_types[system.connectors[ConnectorId(std::size_t{net_.graph.nodes[row].connector})].type];
  if (type.clauses[0].up.is_valid()) return {};
  const std::vector<GuardLiterals::Place> sources = sources_of(row);
  const std::optional<Lit> guard = guards_.literal(type.clauses[0].guard, [&](const Expr& e) {
    return e.op == Op::LoadBind && e.index < sources.size() ? std::optional(sources[e.index]) : std::nullopt;
  });
  if (!guard) return {};
  std::vector<u32> children;
  for (const Edge& child : net_.graph.children(row)) children.push_back(child.node);
  const Lacking below = all_of(children);
  if (below.kind == Lacking::Kind::Always) return below;
  if (below.kind == Lacking::Kind::Never) return {Lacking::Kind::Literal, -*guard};
  const Lit lacking = solver_.new_variable();
  solver_.add({-lacking, below.literal, -*guard});
  return {Lacking::Kind::Literal, lacking};
}

// A guarded rendezvous whose guard reads followed data: for each combination of the modes that it reads in which the
// guard is true, another part must lack something.
void Encoding::add_guarded_rendezvous(u32 row) {
  if (!is_guarded_rendezvous(row)) return;
  const System& system = *net_.system;
  const Connector& connector = system.connectors[ConnectorId(std::size_t{net_.graph.nodes[row].connector})];
  const ConnectorType& type = system.connector_types[connector.type];
  const std::vector<GuardLiterals::Place> sources = sources_of(row);
  std::vector<u32> atoms;
  for_each_expr(system.code, type.clauses[0].guard, [&](const Expr& e) {
    if (e.op != Op::LoadBind || e.index >= sources.size()) return;
    if (std::find(atoms.begin(), atoms.end(), sources[e.index].atom) == atoms.end())
      atoms.push_back(sources[e.index].atom);
  });
  std::vector<std::vector<u32>> choices;
  std::size_t combinations = 1;
  const ConnectorId id(std::size_t{net_.graph.nodes[row].connector});
  for (u32 atom : atoms) {
    choices.emplace_back();
    const u32 base = net_.mode_base[atom];
    std::vector<u32> modes(net_.mode_base[atom + 1] - base);
    std::iota(modes.begin(), modes.end(), 0);
    for (std::size_t p = 0; p < connector.ports.size(); ++p) {
      const PortRef& ref = connector.ports[p];
      if (ref.atom.value != atom) continue;
      if (const u32 node = net_.port_node(id, p); is_use(node)) modes = sources_of_moves(node);
      std::erase_if(modes, [&](u32 mode) { return net_.class_at(atom).is_sure[ref.port][mode] == 0; });
    }
    for (u32 mode : modes) {
      if (reachable_.is_on(base + mode)) choices.back().push_back(base + mode);
    }
    combinations *= choices.back().size();
    if (combinations == 0 || combinations > kMaxCombinations) return;
  }
  std::vector<Lit> others;
  for (std::size_t p = 0; p < connector.ports.size(); ++p) {
    if (std::find(atoms.begin(), atoms.end(), connector.ports[p].atom.value) != atoms.end()) continue;
    const Lacking& below = lacking_[net_.port_node(id, p)];
    if (below.kind == Lacking::Kind::Always) return;
    if (below.kind == Lacking::Kind::Literal) others.push_back(below.literal);
  }
  for (std::size_t number = 0; number < combinations; ++number) {
    std::vector<u32> chosen;
    std::size_t rest = number;
    for (const std::vector<u32>& modes : choices) {
      chosen.push_back(modes[rest % modes.size()]);
      rest /= modes.size();
    }
    std::vector<AbstractValue> bind;
    for (const GuardLiterals::Place& source : sources) {
      const auto at = std::find(atoms.begin(), atoms.end(), source.atom);
      if (at == atoms.end()) {
        bind.emplace_back();
        continue;
      }
      const u32 mode = chosen[static_cast<std::size_t>(at - atoms.begin())] - net_.mode_base[source.atom];
      bind.push_back(net_.class_at(source.atom).modes[mode].values[source.variable]);
    }
    const AbstractValue guard = evaluate(system.code, type.clauses[0].guard, {}, bind);
    if (!guard.is_known || guard.value == 0) continue;
    std::vector<Lit> clause = others;
    for (u32 mode : chosen) clause.push_back(-marked_[mode]);
    solver_.add(clause);
  }
}

void Encoding::add_step(const Lacking& lacking) {
  if (lacking.kind == Lacking::Kind::Literal) solver_.add({lacking.literal});
  else if (lacking.kind == Lacking::Kind::Never) solver_.add(std::span<const Lit>{});
}

bool Encoding::add(const TokenInvariant& invariant, Lit on) {
  if (invariant.kind == InvariantKind::Sum) {
    WeightedSum sum;
    if (!build_weighted_sum(net_, invariant, is_reachable_, sum)) return false;
    add_weighted_sum(sum, marked_, solver_, on);
    return true;
  }
  std::vector<Lit> modes;
  for (u32 mode : invariant.modes) {
    if (marked_[mode] != 0) modes.push_back(marked_[mode]);
  }
  if (on != 0) modes.push_back(-on);
  solver_.add(modes);
  if (invariant.kind == InvariantKind::OneToken) add_at_most_one(solver_, modes);
  return true;
}

std::vector<std::uint8_t> Encoding::marked() const {
  std::vector<std::uint8_t> result(net_.mode_count(), 0);
  for (u32 mode = 0; mode < net_.mode_count(); ++mode)
    result[mode] = marked_[mode] != 0 && solver_.is_true(marked_[mode]) ? 1 : 0;
  return result;
}

}  // namespace bip::verify
