// Promises of instances: compounds, atoms, connectors and their bindings, priority rules.
//
// Needs sound types (validate.cpp stops before if they are not). Linear.
#include <algorithm>

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
    const std::vector<DataVariable>& variables = system.atom_types[row.type].variables;
    const std::size_t count = row.args.size();
    const bool fits = count <= variables.size() && (count == 0 || variables[count - 1].is_param) &&
                      (count == variables.size() || !variables[count].is_param);
    if (!problems.expect(fits, "there is not one argument a parameter")) continue;
    for (std::size_t a = 0; a < count; ++a) check_value(system, row.args[a], variables[a].type, problems);
    for (const Transition& t : system.atom_types[row.type].transitions) {
      if (t.weight.param == Weight::kNone || t.weight.param >= count) continue;
      const Value& arg = row.args[t.weight.param];
      problems.expect(is_weight(arg.type == Type::Float ? arg.float_value : arg.int_value),
                      "a weight's argument is no number above 0");
    }
  }
}

void check_data(const System& system, const DataRef& data, Problems& problems) {
  if (problems.expect(system.atoms.contains(data.atom), "data of no atom"))
    problems.expect(data.variable < system.atom_types[system.atoms[data.atom].type].variables.size(),
                    "data is no variable of its atom");
}

/// What is bound, measured once: the port type and the connectors below. `PortTypeId()`: broken, and said so.
class Bindings {
 public:
  Bindings(const System& system, Problems& problems)
      : system_(system), problems_(problems), bound_(system.connectors.size(), false) {}

  /// Choices first: connectors need them. A choice has no place in the order but that of its last connector.
  void check_choices() {
    for (std::size_t k = 0; k < system_.choices.size(); ++k) {
      const Choice& row = system_.choices[k];
      problems_.at(Table::Choices, k);
      Seen seen;
      problems_.expect(!row.ports.empty(), "a choice has no ports");
      for (const PortRef& ref : row.ports) {
        if (!problems_.expect(ref.kind != PortRef::Kind::Choice, "a choice within a choice")) continue;
        const PortTypeId type = port_type(ref, seen.end);
        if (seen.type.is_valid() && type.is_valid())
          problems_.expect(same_variables(system_, type, seen.type), "the ports of a choice have different variables");
        if (type.is_valid()) seen.type = type;
      }
      choices_.push_back(seen);
    }
  }

  void check(std::size_t row, const PortRef& ref, PortTypeId wanted) {
    std::size_t end = 0;
    PortTypeId type;
    if (ref.kind == PortRef::Kind::Choice) {
      if (!problems_.expect(ref.choice < choices_.size(), "a parameter is bound to no choice")) return;
      type = choices_[ref.choice].type;
      end = choices_[ref.choice].end;
      if (!mark_choice(ref.choice)) type = {};
    } else {
      if (ref.kind == PortRef::Kind::Connector && !problems_.expect(ref.connector.value < row, kNotEarlier)) return;
      type = port_type(ref, end);
      if (ref.kind == PortRef::Kind::Connector && type.is_valid()) bound_[ref.connector.value] = true;
    }
    if (!type.is_valid()) return;
    problems_.expect(end <= row, kNotEarlier);
    problems_.expect(same_variables(system_, type, wanted), "a parameter is bound to a port with other variables");
  }
  [[nodiscard]] bool is_bound(std::size_t row) const { return bound_[row]; }

 private:
  static constexpr const char* kNotEarlier = "a parameter is bound to no earlier connector";
  struct Seen {
    PortTypeId type{};
    std::size_t end = 0;  // one past the last connector
    bool marked = false;
  };
  /// The connectors of a choice are bound once some connector binds the choice.
  bool mark_choice(std::size_t choice) {
    if (!choices_[choice].type.is_valid()) return false;
    if (choices_[choice].marked) return true;
    choices_[choice].marked = true;
    for (const PortRef& ref : system_.choices[choice].ports)
      if (ref.kind == PortRef::Kind::Connector && system_.connectors.contains(ref.connector))
        bound_[ref.connector.value] = true;
    return true;
  }
  PortTypeId port_type(const PortRef& ref, std::size_t& end) {
    if (ref.kind == PortRef::Kind::Atom) {
      if (!problems_.expect(system_.atoms.contains(ref.atom), "a parameter is bound to no atom")) return {};
      const std::vector<Port>& ports = system_.atom_types[system_.atoms[ref.atom].type].ports;
      if (!problems_.expect(ref.port < ports.size(), "a parameter is bound to no port of its atom") ||
          !problems_.expect(ports[ref.port].exported, "a parameter is bound to a port that is not exported"))
        return {};
      return ports[ref.port].type;
    }
    if (!problems_.expect(system_.connectors.contains(ref.connector), kNotEarlier)) return {};
    const ConnectorType& type = system_.connector_types[system_.connectors[ref.connector].type];
    if (!problems_.expect(type.exports, "a parameter is bound to a connector that exports no port")) return {};
    end = std::max(end, static_cast<std::size_t>(ref.connector.value) + 1);
    return type.export_type;
  }

  const System& system_;
  Problems& problems_;
  std::vector<bool> bound_;
  std::vector<Seen> choices_;
};

void check_connectors(const System& system, Problems& problems) {
  for (std::size_t k = 0; k < system.connectors.size(); ++k) {
    const Connector& row = system.connectors.rows()[k];
    problems.at(Table::Connectors, k);
    check_loc(system, row.loc, problems);
    check_parent(system, row.parent, problems);
    // Bindings are measured by the types: nothing more can be said.
    problems.expect(is_weight(row.weight), "a weight is no number above 0");
    if (!problems.expect(system.connector_types.contains(row.type), "the type is no row")) return;
  }
  Bindings bindings(system, problems);
  bindings.check_choices();
  for (std::size_t k = 0; k < system.connectors.size(); ++k) {
    const Connector& row = system.connectors.rows()[k];
    problems.at(Table::Connectors, k);
    const ConnectorType& type = system.connector_types[row.type];
    if (problems.expect(row.ports.size() == type.params.size(), "there is not one port a parameter"))
      for (std::size_t p = 0; p < row.ports.size(); ++p) bindings.check(k, row.ports[p], type.params[p].type);
    for (const ShownPort& shown : row.shown) {
      problems.expect(
          shown.param < row.ports.size() && (&shown == row.shown.data() || (&shown)[-1].param < shown.param),
          "`shown` is not in the order of the parameters");
      problems.expect(system.compounds.contains(shown.compound), "`shown` names no compound");
    }
    if (!problems.expect(row.data.size() == type.data_reads.size(), "there is not one datum a data read")) continue;
    for (std::size_t d = 0; d < row.data.size(); ++d) {
      check_data(system, row.data[d], problems);
      if (!problems.empty()) continue;
      const DataVariable& variable =
          system.atom_types[system.atoms[row.data[d].atom].type].variables[row.data[d].variable];
      problems.expect(variable.type == type.data_reads[d].type, "a datum has not the type of its data read");
    }
  }
  for (std::size_t k = 0; k < system.connectors.size(); ++k) {
    problems.at(Table::Connectors, k);
    problems.expect(system.connectors.rows()[k].bound == bindings.is_bound(k),
                    "`bound` is wrong: it says whether a connector binds this one");
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
