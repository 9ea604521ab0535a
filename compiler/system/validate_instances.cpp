// Promises of instances: compounds, atoms, connectors and their bindings, priority rules.
//
// Needs sound types (validate.cpp stops before if they are not). Linear.
#include "compiler/system/validate_problems.hpp"

namespace bip::system {
namespace {

void check_value(const System& system, const Value& value, Type wanted, Problems& problems) {
  if (!problems.expect(value.type == wanted, "an argument has not its parameter's type")) return;
  const auto bits = static_cast<std::uint32_t>(value.int_value);
  if (value.type == Type::Bool) problems.expect(bits <= 1, "a bool is neither 0 nor 1");
  if (value.type == Type::String) problems.expect(bits < system.code.strings.size(), "an argument's string is no row");
}

void check_parent(const System& system, CompoundId parent, Problems& problems) {
  problems.expect(system.compounds.contains(parent), "the parent is no row of the compounds");
}

void check_compounds(const System& system, Problems& problems) {
  problems.at(Table::Whole, 0);
  problems.expect(!system.compounds.empty(), "there is no root compound");
  for (std::size_t k = 0; k < system.compounds.size(); ++k) {
    const Compound& row = system.compounds.rows()[k];
    problems.at(Table::Compounds, k);
    check_loc(system, row.loc, problems);
    if (k == 0) {
      problems.expect(!row.parent.is_valid(), "row 0 is the root, which has no parent");
    } else {
      problems.expect(row.parent.value < k, "the parent is no earlier row");
    }
  }
}

void check_atoms(const System& system, Problems& problems) {
  for (std::size_t k = 0; k < system.atoms.size(); ++k) {
    const Atom& row = system.atoms.rows()[k];
    problems.at(Table::Atoms, k);
    check_loc(system, row.loc, problems);
    check_parent(system, row.parent, problems);
    if (!problems.expect(system.atom_types.contains(row.type), "the type is no row")) continue;
    const std::vector<Slot>& slots = system.atom_types[row.type].slots;
    const std::size_t count = row.args.size();
    const bool fits = count <= slots.size() && (count == 0 || slots[count - 1].is_param) &&
                      (count == slots.size() || !slots[count].is_param);
    if (!problems.expect(fits, "there is not one argument a parameter")) continue;
    for (std::size_t a = 0; a < count; ++a) check_value(system, row.args[a], slots[a].type, problems);
  }
}

void check_data(const System& system, const DataRef& data, Problems& problems) {
  if (problems.expect(system.atoms.contains(data.atom), "data of no atom"))
    problems.expect(data.slot < system.atom_types[system.atoms[data.atom].type].slots.size(), "data is no slot of its atom");
}

/// The port's variables are those of the parameter: as many, of the same types.
bool same_variables(const System& system, PortTypeId a, PortTypeId b) {
  if (a == b) return true;
  const std::vector<Variable>& left = system.port_types[a].variables;
  const std::vector<Variable>& right = system.port_types[b].variables;
  if (left.size() != right.size()) return false;
  for (std::size_t k = 0; k < left.size(); ++k)
    if (left[k].type != right[k].type) return false;
  return true;
}

void check_binding(const System& system, std::size_t row, const PortRef& ref, PortTypeId wanted, std::vector<bool>& bound,
                   Problems& problems) {
  PortTypeId actual;
  if (ref.kind == PortRef::Kind::Atom) {
    if (!problems.expect(system.atoms.contains(ref.atom), "a parameter is bound to no atom")) return;
    const std::vector<Port>& ports = system.atom_types[system.atoms[ref.atom].type].ports;
    if (!problems.expect(ref.port < ports.size(), "a parameter is bound to no port of its atom") ||
        !problems.expect(ports[ref.port].exported, "a parameter is bound to a port that is not exported"))
      return;
    actual = ports[ref.port].type;
  } else {
    if (!problems.expect(ref.connector.value < row, "a parameter is bound to no earlier connector")) return;
    const ConnectorType& type = system.connector_types[system.connectors[ref.connector].type];
    if (!problems.expect(type.exports, "a parameter is bound to a connector that exports no port")) return;
    bound[ref.connector.value] = true;
    actual = type.export_type;
  }
  problems.expect(same_variables(system, actual, wanted), "a parameter is bound to a port with other variables");
}

void check_connectors(const System& system, Problems& problems) {
  std::vector<bool> bound(system.connectors.size(), false);
  for (std::size_t k = 0; k < system.connectors.size(); ++k) {
    const Connector& row = system.connectors.rows()[k];
    problems.at(Table::Connectors, k);
    check_loc(system, row.loc, problems);
    check_parent(system, row.parent, problems);
    // Later rows measure their bindings by this one's type: nothing more can be said.
    if (!problems.expect(system.connector_types.contains(row.type), "the type is no row")) return;
    const ConnectorType& type = system.connector_types[row.type];
    if (problems.expect(row.ports.size() == type.params.size(), "there is not one port a parameter"))
      for (std::size_t p = 0; p < row.ports.size(); ++p)
        check_binding(system, k, row.ports[p], type.params[p].type, bound, problems);
    if (!problems.expect(row.data.size() == type.data_reads.size(), "there is not one datum a data read")) continue;
    for (std::size_t d = 0; d < row.data.size(); ++d) {
      check_data(system, row.data[d], problems);
      if (!problems.empty()) continue;
      const Slot& slot = system.atom_types[system.atoms[row.data[d].atom].type].slots[row.data[d].slot];
      problems.expect(slot.type == type.data_reads[d].type, "a datum has not the type of its data read");
    }
  }
  for (std::size_t k = 0; k < bound.size(); ++k) {
    problems.at(Table::Connectors, k);
    problems.expect(system.connectors.rows()[k].bound == bound[k], "`bound` is wrong: it says whether a connector binds this one");
  }
}

void check_pattern(const System& system, const Pattern& pattern, Problems& problems) {
  if (pattern.any_connector) return;
  if (!problems.expect(system.connectors.contains(pattern.connector), "a pattern's connector is no row")) return;
  if (pattern.any_interaction) return;
  const std::size_t count = system.connector_types[system.connectors[pattern.connector].type].params.size();
  problems.expect(!pattern.params.empty(), "a pattern is empty");
  for (std::size_t k = 0; k < pattern.params.size(); ++k) {
    problems.expect(pattern.params[k] < count, "a pattern's parameter is no row");
    problems.expect(k == 0 || pattern.params[k - 1] < pattern.params[k], "a pattern's parameters are not sorted");
  }
}

}  // namespace

void check_instances(const System& system, Problems& problems) {
  check_compounds(system, problems);
  check_atoms(system, problems);
  // Bindings are measured by the atoms' types.
  if (problems.empty()) check_connectors(system, problems);
}

void check_priorities(const System& system, Problems& problems) {
  for (std::size_t k = 0; k < system.priorities.size(); ++k) {
    const Priority& row = system.priorities.rows()[k];
    problems.at(Table::Priorities, k);
    check_loc(system, row.loc, problems);
    check_parent(system, row.parent, problems);
    check_pattern(system, row.low, problems);
    check_pattern(system, row.high, problems);
    problems.expect(!(row.low.any_connector && row.high.any_connector), "both sides are `any`");
    for (const DataRef& data : row.data) check_data(system, data, problems);
  }
}

}  // namespace bip::system
