// See error_sources.hpp.
#include "compiler/pipeline/error_sources.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "compiler/lower/code_facts.hpp"

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

}  // namespace

bool can_end_in_error(const System& system) {
  if (!system.priorities.empty()) return true;
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
