// See region_net.hpp.
#include "compiler/verify/regions/region_net.hpp"

#include <algorithm>
#include <set>

#include "compiler/model/code_uses.hpp"
#include "compiler/verify/invariants/intervals.hpp"
#include "compiler/verify/net/abstract_code.hpp"

namespace bip::verify {

namespace {

// The cost of a connector is quadratic in its ports.
constexpr std::size_t kMostPorts = 64;

bool has_flat_rendezvous(const ConnectorType& type) {
  if (type.exports || type.define.empty()) return false;
  const auto is_plain_leaf = [&](u32 child) { return type.define[child].is_leaf && !type.define[child].trigger; };
  const DefineNode& root = type.define.front();
  if (root.is_leaf) return !root.trigger && type.params.size() == 1;
  const bool is_flat = std::all_of(root.children.begin(), root.children.end(), is_plain_leaf);
  // The only interaction is the one of all parameters.
  return is_flat && root.children.size() == type.params.size() && type.clauses.size() <= 1;
}

bool has_number_twice(std::vector<u32> numbers) {
  std::sort(numbers.begin(), numbers.end());
  return std::adjacent_find(numbers.begin(), numbers.end()) != numbers.end();
}

RegionConstants own_constants_of(const RegionNet& net, u32 atom) {
  const System& system = *net.system;
  const Atom& row = system.atoms[AtomId(std::size_t{atom})];
  const AtomType& type = system.atom_types[row.type];
  RegionConstants constants(net.values.count);
  std::vector<AbstractValue> params(type.variables.size());
  for (u32 k = 0; k < type.variables.size(); ++k) {
    if (type.variables[k].type != Type::Int) continue;
    if (type.variables[k].is_param && k < row.args.size()) params[k] = known(row.args[k].int_value);
    if (net.is_fixed(atom, k)) constants[net.values.class_of[row.type.value][k]].push_back(net.range(atom, k).low);
  }
  for (const ValueClasses::Attached& attached : net.values.attached[row.type.value]) {
    const AbstractValue value = evaluate(system.code, attached.expr, params, {});
    if (value.is_known) constants[attached.value_class].push_back(value.value + attached.offset);
  }
  return constants;
}

void sort_constants(RegionConstants& constants) {
  for (std::vector<std::int64_t>& values : constants) {
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
  }
}

// What the code of connector types reads and writes of what they bind.
void read_connector_types(RegionNet& net) {
  for (const ConnectorType& type : net.system->connector_types) {
    const u32 binds = type.bind_count(net.system->port_types);
    std::vector<std::uint8_t>& assigned = net.assigned.emplace_back(binds, std::uint8_t{0});
    std::vector<bool>& reads = net.reads.emplace_back(binds, false);
    for (const Clause& clause : type.clauses) {
      model::mark_reads(net.system->code, clause.guard, Op::LoadBind, reads);
      for (const StmtId body : {clause.up, clause.down}) {
        model::for_each_assigned(net.system->code, body, Op::LoadBind, [&](u32 bind) { assigned[bind] = 1; });
        model::for_each_stmt(net.system->code, body,
                             [&](const Stmt& s) { model::mark_reads(net.system->code, s.value, Op::LoadBind, reads); });
      }
    }
  }
}

void find_written(RegionNet& net) {
  const System& system = *net.system;
  for (const AtomType& type : system.atom_types) net.written.emplace_back(type.ports.size());
  for (const Connector& connector : system.connectors) {
    const ConnectorType& type = system.connector_types[connector.type];
    for (std::size_t param = 0; param < connector.ports.size(); ++param) {
      const PortRef& ref = connector.ports[param];
      const std::vector<u32>& variables = net.type_of(ref.atom.value).ports[ref.port].variables;
      std::vector<u32>& written = net.written[system.atoms[ref.atom].type.value][ref.port];
      for (u32 k = 0; k < variables.size(); ++k) {
        const auto at = std::lower_bound(written.begin(), written.end(), variables[k]);
        const bool is_new = at == written.end() || *at != variables[k];
        if (is_new && net.assigned[connector.type.value][type.params[param].first_bind + k] != 0)
          written.insert(at, variables[k]);
      }
    }
  }
}

}  // namespace

bool is_plain_rendezvous(const System& system) {
  for (const ConnectorType& type : system.connector_types) {
    if (!has_flat_rendezvous(type)) return false;
  }
  for (const AtomType& type : system.atom_types) {
    const auto repeats = [](const Port& port) { return has_number_twice(port.variables); };
    if (std::any_of(type.ports.begin(), type.ports.end(), repeats)) return false;
  }
  std::vector<u32> atoms;
  for (const Connector& connector : system.connectors) {
    if (connector.ports.size() > kMostPorts) return false;
    atoms.clear();
    for (const PortRef& ref : connector.ports) {
      if (ref.kind != PortRef::Kind::Atom) return false;
      atoms.push_back(ref.atom.value);
    }
    if (has_number_twice(atoms)) return false;
  }
  return true;
}

RegionNet build_region_net(const System& system, const rt::Image& image, Writing writing) {
  RegionNet net;
  net.system = &system;
  net.writing = writing;
  read_connector_types(net);
  find_written(net);
  std::vector<std::uint8_t> is_free;
  if (writing == Writing::Anything) {
    is_free.assign(image.cell_count, 0);
    for (u32 atom = 0; atom < image.atoms.size; ++atom) {
      for (const std::vector<u32>& variables : net.written[system.atoms[AtomId(std::size_t{atom})].type.value]) {
        for (const u32 variable : variables) is_free[image.atoms[atom].first_cell + variable] = 1;
      }
    }
  }
  net.ranges = find_ranges(system, image, is_free);
  auto own_steps = static_cast<u32>(system.connectors.size());
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    net.first_cell.push_back(image.atoms[atom].first_cell);
    const AtomType& type = net.type_of(atom);
    net.first_own_step.push_back(own_steps);
    own_steps += static_cast<u32>(type.ports.size());
    for (u32 k = 0; k < type.variables.size(); ++k) {
      const Type of = type.variables[k].type;
      if (of != Type::Int && of != Type::Bool) net.ranges[net.first_cell.back() + k] = kAnyInt;
    }
  }
  net.values = find_value_classes(system);
  net.connectors.resize(system.atoms.size());
  for (std::size_t row = 0; row < system.connectors.size(); ++row) {
    const Connector& connector = system.connectors[ConnectorId(row)];
    net.first_own.push_back(image.connectors[static_cast<u32>(row)].first_cell);
    for (const PortRef& ref : connector.ports) net.connectors[ref.atom.value].push_back(static_cast<u32>(row));
  }
  for (u32 atom = 0; atom < system.atoms.size(); ++atom) {
    net.constants.push_back(own_constants_of(net, atom));
    sort_constants(net.constants.back());
  }
  return net;
}

RegionConstants constants_of(const RegionNet& net, const std::vector<u32>& atoms) {
  RegionConstants all = net.values.general;
  for (const u32 atom : atoms) {
    for (u32 row = 0; row < net.values.count; ++row) {
      const std::vector<std::int64_t>& own = net.constants[atom][row];
      all[row].insert(all[row].end(), own.begin(), own.end());
    }
  }
  sort_constants(all);
  return all;
}

}  // namespace bip::verify
