// See error_sources.hpp.
#include "compiler/pipeline/error_sources.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "compiler/lower/code_facts.hpp"
#include "compiler/model/code_uses.hpp"
#include "compiler/model/exclusive_guards.hpp"
#include "compiler/system/system.hpp"
#include "runtime/core/graph_algorithms.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::pipeline {

namespace {

bool can_fault(const System& system, ExprId guard, StmtId body) {
  return lower::code_facts(system.code, guard, body).may_fault;
}

/// What can go wrong in the atoms of one type.
class AtomErrors {
 public:
  AtomErrors(const System& system, AtomTypeId id) : system_(system), type_(system.atom_types[id]) {
    for (const DataVariable& variable : type_.variables) is_constant_.push_back(variable.is_param);
    // Transfers write through ports.
    for (const Port& port : type_.ports)
      for (const std::uint32_t variable : port.variables) is_constant_[variable] = false;
    const auto note_stores = [this](StmtId body) {
      for_each_store(body, [this](const Stmt& store) { is_constant_[store.index] = false; });
    };
    note_stores(type_.initial_action);
    for (const Transition& t : type_.transitions) note_stores(t.action);
    for (const Atom& atom : system.atoms)
      if (atom.type == id) atoms_.push_back(&atom);
  }

  /// Returns false only if no atom of the type can end a run in an error.
  [[nodiscard]] bool can_happen() const {
    if (!type_.is_automaton() || !type_.priorities.empty()) return true;
    if (can_fault({}, type_.initial_action) || can_set_clock_wrongly(type_.initial_action) ||
        can_fault(type_.initial_resume))
      return true;
    // Where an invariant of time does not hold, time stands still: no error.
    if (std::any_of(type_.invariants.begin(), type_.invariants.end(), [this](const Invariant& invariant) {
          return invariant.condition.is_valid() || can_fault({}, invariant.when.measure);
        }))
      return true;
    for (std::size_t row = 0; row < type_.transitions.size(); ++row) {
      const Transition& t = type_.transitions[row];
      if (t.port == Transition::kInternal || can_fault(t.guard, t.action) || can_fault({}, t.when.measure) ||
          can_fault(t.resume) || can_set_clock_wrongly(t.action))
        return true;
      for (std::size_t before = 0; before < row; ++before)
        if (can_both_be_taken(type_.transitions[before], t)) return true;
    }
    return false;
  }

 private:
  template <class Visit>
  void for_each_store(StmtId body, const Visit& visit) const {
    model::for_each_stmt(system_.code, body, [&](const Stmt& s) {
      if (model::assigned_variable(s, Op::LoadSelf)) visit(s);
    });
  }

  // An error at once: which one is meant?
  [[nodiscard]] bool can_both_be_taken(const Transition& first, const Transition& second) const {
    return first.port == second.port && first.from == second.from && !are_exclusive(first.when, second.when) &&
           !are_exclusive(system_.code, first.guard, second.guard);
  }

  [[nodiscard]] bool can_fault(ExprId guard, StmtId body) const {
    const lower::CodeFacts facts = lower::code_facts(system_.code, guard, body);
    return facts.calls || !std::all_of(facts.divisors.begin(), facts.divisors.end(),
                                       [this](ExprId divisor) { return divides_soundly(system_.code.exprs[divisor]); });
  }
  [[nodiscard]] bool can_fault(const Resume& resume) const {
    return resume.present && (can_fault(resume.guard, {}) || can_fault({}, resume.when.measure));
  }

  // A parameter that is neither 0 nor -1 in any atom.
  [[nodiscard]] bool divides_soundly(const Expr& divisor) const {
    return divisor.op == Op::LoadSelf && is_constant_[divisor.index] &&
           std::all_of(atoms_.begin(), atoms_.end(), [&](const Atom* atom) {
             BIP_ASSERT(divisor.index < atom->args.size(), "parameter {} of {}", divisor.index, atom->args.size());
             const std::int32_t value = atom->args[divisor.index].int_value;
             return value != 0 && value != -1;
           });
  }

  // Clocks hold kMaxTicks, and no int is more than that of seconds. Speeds are not looked at.
  [[nodiscard]] bool can_set_clock_wrongly(StmtId body) const {
    bool found = false;
    for_each_store(body, [&](const Stmt& store) {
      for (const Clock& clock : type_.clocks) {
        if (store.index == clock.variable + static_cast<std::uint32_t>(ClockVariable::Speed)) found = true;
        if (store.index != clock.variable + static_cast<std::uint32_t>(ClockVariable::Value)) continue;
        const Expr& value = system_.code.exprs[store.value];
        const double most = value.op == Op::ConstFloat ? std::fabs(value.float_value) : 0x1p31;
        const bool is_known = value.op == Op::ConstFloat || value.op == Op::IntToFloat;
        found = found || !is_known || !(most * static_cast<double>(clock.unit) <= static_cast<double>(kMaxTicks));
      }
    });
    return found;
  }

  const System& system_;
  const AtomType& type_;
  std::vector<bool> is_constant_;  // by variable: a parameter that nothing writes
  std::vector<const Atom*> atoms_;
};

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
                  [&](AtomTypeId type) { return AtomErrors(system, type).can_happen(); }))
    return true;
  return std::any_of(system.connector_types.begin(), system.connector_types.end(), [&](const ConnectorType& type) {
    return std::any_of(type.clauses.begin(), type.clauses.end(), [&](const Clause& clause) {
      return can_fault(system, clause.guard, clause.up) || can_fault(system, {}, clause.down);
    });
  });
}

}  // namespace bip::pipeline
