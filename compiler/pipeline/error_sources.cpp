// See error_sources.hpp.
#include "compiler/pipeline/error_sources.hpp"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "compiler/lower/code_facts.hpp"
#include "compiler/system/system.hpp"
#include "runtime/core/graph_algorithms.hpp"

namespace bip::pipeline {

namespace {

bool can_fault(const System& system, ExprId guard, StmtId body) {
  return lower::code_facts(system.code, guard, body).may_fault;
}

bool can_fault(const System& system, const AtomType& type) {
  if (!type.is_automaton() || !type.invariants.empty() || !type.priorities.empty()) return true;
  if (can_fault(system, {}, type.initial_action)) return true;
  std::set<std::pair<std::uint32_t, std::uint32_t>> offers;  // place and port
  for (const Transition& t : type.transitions) {
    if (t.port == Transition::kInternal || !offers.emplace(t.from.front(), t.port).second) return true;
    if (can_fault(system, t.guard, t.action)) return true;
  }
  return false;
}

using Successors = std::vector<std::vector<std::uint32_t>>;

bool has_cycle(const Successors& graph) {
  const auto enter = [](std::uint32_t) { return std::size_t{0}; };
  const auto next = [&graph](std::uint32_t node, std::size_t& at) {
    return at == graph[node].size() ? kNoSuccessor : graph[node][at++];
  };
  const auto follow_all = [](std::uint32_t, std::uint32_t) { return true; };
  return !find_cycle(static_cast<std::uint32_t>(graph.size()), enter, next, follow_all).empty();
}

// Connectors whose interactions contain a connector's: those that bind it, and itself.
void add_edges_to_users(const System& system, const PortRef& bound, std::uint32_t user, Successors& users) {
  if (bound.kind == PortRef::Kind::Connector) users[bound.connector.value].push_back(user);
  if (bound.kind != PortRef::Kind::Choice) return;
  for (const PortRef& port : system.choices[bound.choice].ports) add_edges_to_users(system, port, user, users);
}

// Can priorities between interactions close a cycle? Not if no connector comes after itself, where a connector comes
// after those that lose against it or against what contains it: larger interactions of one connector close none.
bool can_close_a_cycle(const System& system) {
  if (system.priorities.empty()) return false;
  Successors users(system.connectors.size());
  for (std::size_t row = 0; row < system.connectors.size(); ++row) {
    for (const PortRef& bound : system.connectors[ConnectorId(row)].ports)
      add_edges_to_users(system, bound, static_cast<std::uint32_t>(row), users);
  }
  // A cycle through users stays one if containing and losing are edges alike.
  Successors after = std::move(users);
  for (const Priority& rule : system.priorities) {
    if (rule.low.any_connector || rule.high.any_connector) return true;
    after[rule.low.connector.value].push_back(rule.high.connector.value);
  }
  return has_cycle(after);
}

}  // namespace

bool can_end_in_error(const System& system) {
  if (can_close_a_cycle(system)) return true;
  std::set<AtomTypeId> atom_types;
  for (const Atom& atom : system.atoms) atom_types.insert(atom.type);
  if (std::any_of(atom_types.begin(), atom_types.end(),
                  [&](AtomTypeId type) { return can_fault(system, system.atom_types[type]); }))
    return true;
  return std::any_of(system.connector_types.begin(), system.connector_types.end(), [&](const ConnectorType& type) {
    return std::any_of(type.clauses.begin(), type.clauses.end(), [&](const Clause& clause) {
      return can_fault(system, clause.guard, clause.up) || can_fault(system, {}, clause.down);
    });
  });
}

}  // namespace bip::pipeline
