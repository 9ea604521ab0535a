// Promises of system.hpp, types.hpp and code.hpp, looked up one by one: the entry, and the types of ports and atoms.
//
// Linear in the System, iterative. Stops after the types if they are broken, since instances are measured by them.
#include <fmt/format.h>

#include <unordered_set>

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

void check_port(const System& system, const AtomType& type, const Port& port, Problems& problems) {
  check_loc(system, port.loc, problems);
  if (!problems.expect(system.port_types.contains(port.type), "a port's type is no row")) return;
  const std::vector<Variable>& variables = system.port_types[port.type].variables;
  if (!problems.expect(port.slots.size() == variables.size(), "a port has not one slot a variable of its type")) return;
  for (std::size_t k = 0; k < variables.size(); ++k) {
    if (problems.expect(port.slots[k] < type.slots.size(), "a port's slot is no row"))
      problems.expect(type.slots[port.slots[k]].type == variables[k].type, "a port's slot has not the variable's type");
  }
}

void check_atom_type(const System& system, const AtomType& type, Problems& problems) {
  check_loc(system, type.loc, problems);
  bool data_begun = false;
  for (const Slot& slot : type.slots) {
    check_loc(system, slot.loc, problems);
    problems.expect(is_type(slot.type), "a slot has no type");
    problems.expect(!(data_begun && slot.is_param), "a parameter's slot comes after data");
    data_begun = data_begun || !slot.is_param;
  }
  for (const Port& port : type.ports) check_port(system, type, port, problems);

  const auto check_places = [&](const std::vector<std::uint32_t>& places) {
    problems.expect(!places.empty(), "a set of places is empty");
    for (const std::uint32_t place : places) problems.expect(place < type.places.size(), "a place is no row");
  };
  check_places(type.initial);
  for (const Transition& transition : type.transitions) {
    check_loc(system, transition.loc, problems);
    problems.expect(transition.port == Transition::kInternal || transition.port < type.ports.size(),
                    "a transition's port is no row");
    check_places(transition.from);
    check_places(transition.to);
  }
}

}  // namespace

void check_port_and_atom_types(const System& system, Problems& problems) {
  for (std::size_t k = 0; k < system.port_types.size(); ++k) {
    const PortType& type = system.port_types.rows()[k];
    problems.at(Table::PortTypes, k);
    check_loc(system, type.loc, problems);
    for (const Variable& variable : type.variables) {
      check_loc(system, variable.loc, problems);
      problems.expect(is_type(variable.type), "a variable has no type");
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
  check_port_and_atom_types(system, problems);
  check_connector_types(system, problems);
  if (problems.empty()) check_instances(system, problems);
  if (problems.empty()) check_priorities(system, problems);
  if (problems.empty()) check_code(system, problems);
  return problems.list();
}

std::vector<std::string> validate(const System& system) {
  static constexpr const char* kNames[kTables] = {"system", "port type", "atom type", "connector type",
                                                  "compound", "atom",    "connector", "priority"};
  std::vector<std::string> out;
  for (const Problem& problem : find_problems(system)) {
    if (problem.table == Table::Whole) {
      out.push_back(fmt::format("system: {}", problem.message));
    } else {
      out.push_back(fmt::format("{} {}: {}", kNames[static_cast<std::size_t>(problem.table)], problem.row, problem.message));
    }
  }
  return out;
}

}  // namespace bip::system
