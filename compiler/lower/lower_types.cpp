// Lowers types to runtime tables, with one code unit per guard, action and transfer of a type.
//
// Linear in the size of the types, independent of the instances.
#include <algorithm>

#include "compiler/lower/code_facts.hpp"
#include "compiler/lower/pools.hpp"
#include "compiler/lower/range_code.hpp"
#include "compiler/model/model.hpp"
#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::lower {

namespace {

rt::Span<rt::Var> lower_variables(Lowering& l, const std::vector<DataVariable>& variables) {
  std::vector<rt::Var> vars;
  vars.reserve(variables.size());
  for (const DataVariable& variable : variables) {
    vars.push_back({variable.name.c_str(), cell_type_of(variable.type), variable.is_param, variable.exported});
  }
  return l.pools.list(vars);
}

void lower_port_type(Lowering& l, const PortType& type) {
  std::vector<rt::Var> vars;
  for (const Variable& v : type.variables) vars.push_back({v.name.c_str(), cell_type_of(v.type), false, false});
  l.pools.port_types.push_back({type.name.c_str(), l.pools.list(vars)});
}

void lower_atom_rules(Lowering& l, std::uint32_t row, const AtomType& type, rt::AtomType& to) {
  const auto port = [](std::uint32_t k) { return k == AtomPriority::kAnyPort ? rt::kNone : k; };
  std::vector<rt::AtomPriority> priorities;
  for (const AtomPriority& p : type.priorities) {
    const std::uint32_t guard = l.guard(CodeOwner::Atom, row, type.name + "_" + p.name + "_guard", p.guard);
    priorities.push_back({p.name.c_str(), port(p.low), port(p.high), guard, loc_of(p.loc)});
  }
  to.priorities = l.pools.list(priorities);
  std::vector<rt::Invariant> invariants;
  for (const Invariant& i : type.invariants) {
    const std::uint32_t condition = l.guard(CodeOwner::Atom, row, type.name + "_" + i.name, i.condition);
    invariants.push_back(
        {i.name.c_str(), static_cast<rt::InvariantScope>(i.scope), l.pools.list(i.places), condition, loc_of(i.loc)});
  }
  to.invariants = l.pools.list(invariants);
}

// What decides whether ports of an atom are enabled: does any of it call C++?
bool guards_call(const CodeTable& code, const AtomType& type) {
  const auto calls = [&](ExprId guard, const TimeGuard& when) { return code_facts(code, guard, when.measure).calls; };
  return std::any_of(
             type.transitions.begin(), type.transitions.end(),
             [&](const Transition& t) { return calls(t.guard, t.when) || calls(t.resume.guard, t.resume.when); }) ||
         std::any_of(type.priorities.begin(), type.priorities.end(),
                     [&](const AtomPriority& p) { return calls(p.guard, {}); }) ||
         std::any_of(type.invariants.begin(), type.invariants.end(),
                     [&](const Invariant& i) { return calls(i.condition, i.when); });
}

void lower_atom_type(Lowering& l, std::uint32_t row, const AtomType& type) {
  rt::AtomType to{};
  to.name = type.name.c_str();
  to.variables = lower_variables(l, type.variables);
  std::vector<rt::Port> ports;
  for (const Port& port : type.ports) {
    ports.push_back(
        {port.name.c_str(), port.type.value, l.pools.list(port.variables), port.exported, loc_of(port.loc)});
  }
  to.ports = l.pools.list(ports);
  std::vector<const char*> places;
  for (const std::string& place : type.places) places.push_back(place.c_str());
  to.places = l.pools.list(places);
  to.initial = l.pools.list(type.initial);
  to.final_places = l.pools.list(type.final_places);
  to.draws = type.draws == AtomType::kNoDraws ? rt::kNone : type.draws;
  to.initial_action = l.action(CodeOwner::Atom, row, type.name + "_initial", type.initial_action);
  std::vector<rt::Transition> transitions;
  for (const Transition& t : type.transitions) {
    const std::string name = transition_name(type, t);
    rt::Transition out{};
    out.port = t.port == Transition::kInternal ? rt::kNone : t.port;
    out.from = l.pools.list(t.from);
    out.to = l.pools.list(t.to);
    out.guard = l.guard(CodeOwner::Atom, row, name + "_guard", t.guard);
    out.action = l.action(CodeOwner::Atom, row, name + "_action", t.action);
    out.loc = loc_of(t.loc);
    if (!t.weight.is_one())
      l.pools.transition_weights.push_back({row, static_cast<std::uint32_t>(transitions.size()), t.weight.value,
                                            t.weight.param == Weight::kNone ? rt::kNone : t.weight.param});
    transitions.push_back(out);
  }
  BIP_ASSERT(row == l.pools.atom_types.size(), "atom type {} comes after {}", row, l.pools.atom_types.size());
  to.transitions = l.pools.list(transitions);
  to.loc = loc_of(type.loc);
  lower_atom_rules(l, row, type, to);
  to.time = lower_time(l, row, type);
  to.guards_call = guards_call(l.system.code, type);
  l.pools.atom_types.push_back(to);
}

// Are there searches of maximal interactions? Then the runtime wants to know code over ranges of values.
bool has_searches(const System& system) {
  bool trigger = false, guard = false;
  for (const ConnectorType& type : system.connector_types) {
    for (const DefineNode& node : type.define) trigger |= node.trigger;
    for (const Clause& clause : type.clauses) guard |= clause.guard.is_valid();
  }
  return trigger && guard;
}

void lower_connector_type(Lowering& l, std::uint32_t row, const ConnectorType& type, bool wants_ranges) {
  rt::ConnectorType to{};
  to.name = type.name.c_str();
  std::vector<rt::ConnectorParam> params;
  for (const ConnectorParam& p : type.params) params.push_back({p.name.c_str(), p.type.value, p.first_bind});
  to.params = l.pools.list(params);
  to.variables = lower_variables(l, type.variables);
  std::vector<rt::DefineNode> define;
  for (const DefineNode& node : type.define) {
    define.push_back({node.is_leaf, node.trigger, node.param, l.pools.list(node.children)});
  }
  to.define = l.pools.list(define);
  std::vector<rt::Clause> clauses;
  for (const Clause& clause : type.clauses) {
    const std::string name = clause_name(type, clause);
    rt::Clause out{};
    out.params = l.pools.list(clause.params);
    out.guard = l.guard(CodeOwner::Connector, row, name + "_guard", clause.guard);
    out.up = l.action(CodeOwner::Connector, row, name + "_up", clause.up);
    out.down = l.action(CodeOwner::Connector, row, name + "_down", clause.down);
    out.loc = loc_of(clause.loc);
    // Then it runs while interactions are computed.
    out.may_fault = code_facts(l.system.code, ExprId{}, clause.up).may_fault;
    out.guard_may_fault = code_facts(l.system.code, clause.guard, StmtId{}).may_fault;
    if (const std::optional<ClauseRanges> ranges = wants_ranges ? clause_ranges(l.system.code, clause) : std::nullopt) {
      out.has_ranges = true;
      out.guard_ranges = l.pools.list(ranges->guard);
      out.up_ranges = l.pools.list(ranges->up);
    }
    clauses.push_back(out);
  }
  BIP_ASSERT(row == l.pools.connector_types.size(), "connector type {} comes after {}", row,
             l.pools.connector_types.size());
  to.clauses = l.pools.list(clauses);
  to.exports = type.exports;
  to.export_name = type.export_name.c_str();
  to.export_type = type.exports ? type.export_type.value : rt::kNone;
  to.export_variables = l.pools.list(type.export_variables);
  to.loc = loc_of(type.loc);
  to.resume_sync = type.resume == ResumeMode::Sync;
  to.is_total = wants_ranges && static_cast<double>(type.clauses.size()) >= model::interaction_count(type);
  l.pools.connector_types.push_back(to);
}

}  // namespace

void lower_types(Lowering& l) {
  const System& s = l.system;
  for (const PortType& type : s.port_types) lower_port_type(l, type);
  std::uint32_t row = 0;
  for (const AtomType& type : s.atom_types) lower_atom_type(l, row++, type);
  row = 0;
  const bool wants_ranges = has_searches(s);
  for (const ConnectorType& type : s.connector_types) lower_connector_type(l, row++, type, wants_ranges);
}

}  // namespace bip::lower
