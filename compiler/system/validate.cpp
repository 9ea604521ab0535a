// Promises of system.hpp, types.hpp and code.hpp, looked up one by one: the entry, and the types of ports and atoms.
//
// Linear in the System, iterative. Stops after the types if they are broken, since instances are measured by them.
#include <fmt/format.h>

#include <algorithm>
#include <unordered_set>

#include "compiler/model/draws.hpp"
#include "compiler/system/bsys.hpp"
#include "compiler/system/validate_problems.hpp"

namespace bip::system {
namespace {

void check_strings(const System& system, Problems& problems) {
  const std::vector<std::string>& strings = system.code.strings;
  problems.expect(strings.empty() || strings[0].empty(), "row 0 of the strings is not the empty one");
  const std::unordered_set<std::string_view> distinct(strings.begin(), strings.end());
  problems.expect(distinct.size() == strings.size(), "a string constant has two rows");
}

/// What every executor and a C++ compiler must be able to say.
void check_functions(const System& system, Problems& problems) {
  for (const Function& row : system.code.functions) {
    check_loc(system, row.loc, problems);
    problems.expect(is_type(system, row.result), "a function's result has no type");
    const std::size_t count = row.params.size();
    problems.expect(row.kind != FunctionKind::Cast || (count == 1 && row.has_result),
                    "a conversion has not one parameter and a result");
    problems.expect(row.kind != FunctionKind::Draw || model::distribution_of(row) != nullptr,
                    "a draw has the name and the types of no distribution");
    problems.expect(row.kind != FunctionKind::Operator || count == 1 || count == 2,
                    "an operator has one or two parameters");
    for (const FunctionParam& param : row.params) {
      problems.expect(is_type(system, param.type), "a function's parameter has no type");
      problems.expect(!param.by_reference || (param.type != Type::Bool && param.type != Type::String),
                      "bool and string are passed by value");
    }
  }
}

void check_port(const System& system, const AtomType& type, const Port& port, Problems& problems) {
  check_loc(system, port.loc, problems);
  if (!problems.expect(system.port_types.contains(port.type), "a port's type is no row")) return;
  const std::vector<Variable>& variables = system.port_types[port.type].variables;
  if (!problems.expect(port.variables.size() == variables.size(),
                       "a port has not one variable of the atom a variable of its type"))
    return;
  for (std::size_t k = 0; k < variables.size(); ++k) {
    if (problems.expect(port.variables[k] < type.variables.size(), "a port's variable is no row"))
      problems.expect(type.variables[port.variables[k]].type == variables[k].type,
                      "a port's variable has not the variable's type");
  }
}

/// Three variables a clock, in their order, and of no other clock; limits are known.
void check_when(const AtomType& type, const TimeGuard& when, Problems& problems) {
  for (const Bound& bound : when.bounds) {
    const bool has_clocks =
        bound.clock < type.clocks.size() && (bound.minus == Bound::kNone || bound.minus < type.clocks.size());
    if (!problems.expect(has_clocks, "a bound's clock is no row")) continue;
    problems.expect(bound.minus != bound.clock, "a bound is on the difference of a clock with itself");
    problems.expect(bound.minus == Bound::kNone || type.clocks[bound.minus].unit == type.clocks[bound.clock].unit,
                    "a bound is on clocks of two units");
    problems.expect(bound.ticks >= -kMaxTicks && bound.ticks <= kMaxTicks, "a bound is beyond the end of time");
    if (bound.variable == Bound::kNone) continue;
    const bool is_hidden = bound.variable < type.variables.size() && bound.variable >= type.visible_variables();
    if (problems.expect(is_hidden, "a bound's variable is none of the hidden ones"))
      problems.expect(type.variables[bound.variable].type == Type::Float, "a bound's variable is no float");
    problems.expect(when.measure.is_valid(), "nothing measures a bound's limit");
  }
}
void check_time(const AtomType& type, Problems& problems) {
  std::uint32_t next = static_cast<std::uint32_t>(type.visible_variables());
  for (const Clock& clock : type.clocks) {
    problems.expect(clock.unit > 0 && clock.unit <= 86'400'000'000'000, "a clock's unit is not between 1 ns and a day");
    if (!problems.expect(clock.variable == next && clock.variable + kClockVariables <= type.variables.size(),
                         "a clock's variables do not follow those before it"))
      return;
    problems.expect(type.variables[next].type == Type::Float && type.variables[next + 1].type == Type::Bool &&
                        type.variables[next + 2].type == Type::Float,
                    "a clock's variables are not float, bool, float");
    next += kClockVariables;
  }
  if (type.draws != AtomType::kNoDraws) {
    const bool is_hidden = type.draws < type.variables.size() && type.draws >= type.visible_variables();
    if (problems.expect(is_hidden, "a generator's variable is none of the hidden ones"))
      problems.expect(type.variables[type.draws].type == Type::Float, "a generator's variable is no float");
    for (const Clock& clock : type.clocks)
      problems.expect(type.draws < clock.variable || type.draws >= clock.variable + kClockVariables,
                      "a generator's variable is a clock's");
  }
  for (std::size_t k = type.visible_variables(); k < type.variables.size(); ++k)
    problems.expect(!type.variables[k].is_param && !type.variables[k].exported,
                    "a hidden variable is a parameter or exported");
  for (const Port& port : type.ports) {
    problems.expect(!(port.external && port.exported), "a port of events from outside is exported");
    for (const std::uint32_t variable : port.variables)
      problems.expect(variable < type.visible_variables(), "a port shows a hidden variable");
  }
  check_when(type, type.initial_resume.when, problems);
  for (const Transition& row : type.transitions) {
    check_when(type, row.when, problems);
    check_when(type, row.resume.when, problems);
    const Weight& weight = row.weight;
    if (weight.param == Weight::kNone) {
      problems.expect(is_weight(weight.value), "a weight is no number above 0");
    } else if (problems.expect(weight.param < type.variables.size() && weight.value == 1,
                               "a weight's parameter is no row")) {
      const DataVariable& param = type.variables[weight.param];
      problems.expect(param.is_param && (param.type == Type::Int || param.type == Type::Float),
                      "a weight is no parameter that is a number");
    }
    const bool is_timed = !row.when.empty() || row.urgency != Urgency::Lazy || row.resume.present || row.async.present;
    problems.expect(row.port != Transition::kInternal || !is_timed, "an internal transition has to do with time");
    const Async& async = row.async;
    problems.expect(async.present ? async.budget == -1 || (async.budget > 0 && async.budget <= kMaxTicks)
                                  : async.budget == -1 && async.overrun == Async::kNone,
                    "a budget is no time");
    if (async.overrun == Async::kNone) continue;
    problems.expect(async.budget > 0 && async.overrun < type.ports.size() && type.ports[async.overrun].external &&
                        type.ports[async.overrun].variables.empty(),
                    "an overrun has no budget, or its port is not for events without variables");
  }
}

/// Priorities, invariants and merged ports.
void check_rules(const System& system, const AtomType& type, Problems& problems) {
  const auto is_port = [&](std::uint32_t port) { return port < type.ports.size(); };
  for (const AtomPriority& row : type.priorities) {
    check_loc(system, row.loc, problems);
    for (const std::uint32_t port : {row.low, row.high})
      problems.expect(port == AtomPriority::kAnyPort || is_port(port), "a priority's port is no row");
    problems.expect(row.low != row.high, "both sides of a priority are the same");
  }
  for (const Invariant& row : type.invariants) {
    check_loc(system, row.loc, problems);
    problems.expect(row.scope <= InvariantScope::From, "an invariant has no scope");
    problems.expect(row.condition.is_valid() || !row.when.empty(), "an invariant has no condition");
    check_when(type, row.when, problems);
    problems.expect(row.places.empty() == (row.scope == InvariantScope::Always),
                    "an invariant has places if it is not `always`");
    for (std::size_t k = 0; k < row.places.size(); ++k) {
      problems.expect(row.places[k] < type.places.size(), "a place is no row");
      problems.expect(k == 0 || row.places[k - 1] < row.places[k], "an invariant's places are not sorted");
    }
  }
  for (const MergedPort& row : type.merged) {
    check_loc(system, row.loc, problems);
    if (!problems.expect(system.port_types.contains(row.type), "a merged port's type is no row")) continue;
    problems.expect(row.ports.size() >= 2, "a merged port has fewer than two ports");
    for (const std::uint32_t port : row.ports)
      if (problems.expect(is_port(port), "a merged port's port is no row") &&
          system.port_types.contains(type.ports[port].type))
        problems.expect(same_variables(system, type.ports[port].type, row.type),
                        "a merged port's port has other variables");
  }
}

void check_atom_type(const System& system, const AtomType& type, Problems& problems) {
  check_loc(system, type.loc, problems);
  bool data_begun = false;
  for (const DataVariable& variable : type.variables) {
    check_loc(system, variable.loc, problems);
    problems.expect(is_type(system, variable.type), "a variable has no type");
    problems.expect(!(data_begun && variable.is_param), "a parameter's variable comes after data");
    data_begun = data_begun || !variable.is_param;
  }
  for (const Port& port : type.ports) check_port(system, type, port, problems);

  const auto check_places = [&](const std::vector<std::uint32_t>& places) {
    problems.expect(!places.empty(), "a set of places is empty");
    for (const std::uint32_t place : places) problems.expect(place < type.places.size(), "a place is no row");
  };
  check_places(type.initial);
  for (const std::uint32_t place : type.final_places)
    problems.expect(place < type.places.size(), "a final place is no row");
  problems.expect(std::is_sorted(type.final_places.begin(), type.final_places.end(), std::less_equal<>()),
                  "final places are not in order");
  for (const Transition& transition : type.transitions) {
    check_loc(system, transition.loc, problems);
    problems.expect(transition.port == Transition::kInternal || transition.port < type.ports.size(),
                    "a transition's port is no row");
    check_places(transition.from);
    check_places(transition.to);
  }
  check_time(type, problems);
  check_rules(system, type, problems);
}

}  // namespace

bool same_variables(const System& system, PortTypeId a, PortTypeId b) {
  const auto same = [](const Variable& left, const Variable& right) { return left.type == right.type; };
  const std::vector<Variable>& left = system.port_types[a].variables;
  const std::vector<Variable>& right = system.port_types[b].variables;
  return a == b || std::equal(left.begin(), left.end(), right.begin(), right.end(), same);
}

void check_port_and_atom_types(const System& system, Problems& problems) {
  for (std::size_t k = 0; k < system.port_types.size(); ++k) {
    const PortType& type = system.port_types.rows()[k];
    problems.at(Table::PortTypes, k);
    check_loc(system, type.loc, problems);
    for (const Variable& variable : type.variables) {
      check_loc(system, variable.loc, problems);
      problems.expect(is_type(system, variable.type), "a variable has no type");
    }
  }
  for (std::size_t k = 0; k < system.atom_types.size(); ++k) {
    problems.at(Table::AtomTypes, k);
    check_atom_type(system, system.atom_types.rows()[k], problems);
  }
}

std::vector<Problem> find_problems(const System& system) {
  Problems problems;
  check_strings(system, problems);
  check_functions(system, problems);
  check_port_and_atom_types(system, problems);
  check_connector_types(system, problems);
  if (problems.empty()) check_instances(system, problems);
  if (problems.empty()) check_priorities(system, problems);
  if (problems.empty()) check_code(system, problems);
  return problems.list();
}

std::vector<std::string> validate(const System& system) {
  static constexpr const char* kNames[kTables] = {"system", "port type", "atom type", "connector type", "compound",
                                                  "atom",   "choice",    "connector", "priority"};
  std::vector<std::string> out;
  for (const Problem& problem : find_problems(system)) {
    if (problem.table == Table::Whole) {
      out.push_back(fmt::format("system: {}", problem.message));
    } else {
      out.push_back(
          fmt::format("{} {}: {}", kNames[static_cast<std::size_t>(problem.table)], problem.row, problem.message));
    }
  }
  return out;
}

}  // namespace bip::system
