// Lowers instances to rows: first cells, port references and tables of bound variables.
//
// Cells are laid out for atoms first, in the System's order, then for connectors by height. A connector comes after
// those that it binds, so one pass knows every cell that a binding needs. Linear in the number of instances and
// bindings.
#include <algorithm>
#include <map>
#include <utility>

#include "compiler/lower/pools.hpp"
#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::lower {

namespace {

rt::Cell cell_of(const Value& value) {
  rt::Cell cell{};
  if (value.type == Type::Float) {
    cell.f = value.float_value;
  } else {
    cell.bits = static_cast<std::uint32_t>(value.int_value);
  }
  return cell;
}

template <class Row>
std::uint32_t size_of(const std::vector<Row>& rows) {
  return static_cast<std::uint32_t>(rows.size());
}

void lower_atoms(Lowering& l) {
  const System& s = l.system;
  l.pools.atoms.rows.reserve(s.atoms.size());
  for (const Atom& atom : s.atoms) {
    rt::Atom to{};
    to.name = atom.path.c_str();
    to.type = atom.type.value;
    to.first_cell = l.out.image.cell_count;
    to.args = size_of(l.pools.args);
    to.loc = loc_of(atom.loc);
    for (const Value& arg : atom.args) l.pools.args.push_back(cell_of(arg));
    l.out.image.cell_count += size_of(s.atom_types[atom.type].variables);
    l.pools.atoms.rows.push_back(to);
  }
}

std::uint32_t data_row(const Lowering& l, const DataRef& ref) {
  BIP_ASSERT(ref.variable < l.system.atom_types[l.system.atoms[ref.atom].type].variables.size(),
             "variable {} of atom {}", ref.variable, ref.atom);
  return l.pools.atoms.rows[ref.atom.value].first_cell + ref.variable;
}

rt::PortRef port_ref(const PortRef& ref) {
  rt::PortRef to{rt::kNone, rt::kNone, rt::kNone, ref.maximal_only};
  switch (ref.kind) {
    case PortRef::Kind::Atom:
      to.atom = ref.atom.value;
      to.port = ref.port;
      break;
    case PortRef::Kind::Connector: to.connector = ref.connector.value; break;
    case PortRef::Kind::Choice: to.choice = ref.choice; break;
  }
  return to;
}

// The port reference of one parameter, and the rows of its variables; of a choice those of its first port.
void lower_port_ref(Lowering& l, const PortRef& bound) {
  const System& s = l.system;
  l.pools.port_refs.rows.push_back(port_ref(bound));
  const PortRef& ref = bound.kind == PortRef::Kind::Choice ? s.choices[bound.choice].ports[0] : bound;
  if (ref.kind == PortRef::Kind::Atom) {
    const std::uint32_t base = l.pools.atoms.rows[ref.atom.value].first_cell;
    for (const std::uint32_t variable : s.atom_types[s.atoms[ref.atom].type].ports[ref.port].variables) {
      l.pools.binds.rows.push_back({base + variable});
    }
  } else {
    BIP_ASSERT(ref.connector.value < l.pools.connectors.rows.size(), "connector {} comes after one that binds it",
               ref.connector);
    const std::uint32_t base = l.pools.connectors.rows[ref.connector.value].first_cell;
    for (const std::uint32_t variable : s.connector_types[s.connectors[ref.connector].type].export_variables) {
      l.pools.binds.rows.push_back({base + variable});
    }
  }
}

void lower_choices(Lowering& l) {
  for (const Choice& choice : l.system.choices) {
    std::vector<rt::PortRef> ports;
    for (const PortRef& ref : choice.ports) ports.push_back(port_ref(ref));
    l.pools.choices.push_back({choice.name.c_str(), l.pools.list(ports)});
  }
}

// `parent` is the compound's row; images without that column leave it out.
template <class Row>
void set_parent(Row& row, std::uint32_t parent) {
  if constexpr (requires { row.parent; }) row.parent = parent;
}

// Frames by height, so that those of one level of a regular tree lie side by side and can be worked off by a loop.
std::vector<std::uint32_t> frame_rows(Lowering& l) {
  const System& s = l.system;
  std::vector<std::uint32_t> height, rows, first;
  for (const Connector& connector : s.connectors) {
    std::uint32_t above = 0;
    for (const PortRef& ref : connector.ports) {
      BIP_ASSERT(ref.kind != PortRef::Kind::Connector || ref.connector.value < height.size(),
                 "connector {} comes after one that binds it", ref.connector);
      if (ref.kind == PortRef::Kind::Connector) above = std::max(above, height[ref.connector.value] + 1);
    }
    height.push_back(above);
    if (first.size() <= above) first.resize(above + 1, 0);
    first[above] += size_of(s.connector_types[connector.type].variables);
  }
  for (std::uint32_t& row : first) l.out.image.cell_count += std::exchange(row, l.out.image.cell_count);
  for (const Connector& connector : s.connectors) {
    std::uint32_t& next = first[height[rows.size()]];
    rows.push_back(std::exchange(next, next + size_of(s.connector_types[connector.type].variables)));
  }
  return rows;
}

void lower_connectors(Lowering& l) {
  const System& s = l.system;
  l.pools.connectors.rows.reserve(s.connectors.size());
  const std::vector<std::uint32_t> frames = frame_rows(l);
  std::map<std::string_view, const char*> shown_names;
  for (const Connector& connector : s.connectors) {
    rt::Connector to{};
    to.name = connector.path.c_str();
    to.type = connector.type.value;
    to.first_cell = frames[l.pools.connectors.rows.size()];
    to.ports = size_of(l.pools.port_refs.rows);
    to.binds = size_of(l.pools.binds.rows);
    to.bound = connector.bound;
    set_parent(to, connector.parent.value);
    to.loc = loc_of(connector.loc);
    for (const PortRef& ref : connector.ports) lower_port_ref(l, ref);
    for (const ShownPort& shown : connector.shown) {
      const auto [name, is_new] = shown_names.try_emplace(shown.name, nullptr);
      if (is_new) name->second = l.pools.arena.text(shown.name + '\0').data();
      l.pools.shown_ports.push_back({to.ports + shown.param, shown.compound.value, name->second});
    }
    for (const DataRef& ref : connector.data) l.pools.binds.rows.push_back({data_row(l, ref)});
    to.bind_count = size_of(l.pools.binds.rows) - to.binds;
    BIP_ASSERT(size_of(l.pools.port_refs.rows) - to.ports == size_of(connector.ports), "{} ports of connector {}",
               size_of(connector.ports), size_of(l.pools.connectors.rows));
    if (connector.weight != 1)
      l.pools.connector_weights.push_back({size_of(l.pools.connectors.rows), connector.weight});
    l.pools.connectors.rows.push_back(to);
  }
}

rt::Pattern lower_pattern(Lowering& l, const Pattern& pattern) {
  return {pattern.any_connector, pattern.any_connector ? rt::kNone : pattern.connector.value, pattern.any_interaction,
          l.pools.list(pattern.params)};
}

void lower_priorities(Lowering& l) {
  const System& s = l.system;
  l.pools.priorities.reserve(s.priorities.size());
  std::uint32_t row = 0;
  for (const Priority& priority : s.priorities) {
    rt::Priority to{};
    to.name = priority.name.c_str();
    to.parent = priority.parent.value;
    to.low = lower_pattern(l, priority.low);
    to.high = lower_pattern(l, priority.high);
    const std::string name = s.compounds[priority.parent].type + "_" + priority.name + "_guard";
    to.guard = l.guard(CodeOwner::Priority, row++, name, priority.guard);
    to.binds = size_of(l.pools.binds.rows);
    to.bind_count = size_of(priority.data);
    to.loc = loc_of(priority.loc);
    for (const DataRef& ref : priority.data) l.pools.binds.rows.push_back({data_row(l, ref)});
    l.pools.priorities.push_back(to);
  }
}

}  // namespace

void lower_instances(Lowering& l) {
  l.pools.compounds.reserve(l.system.compounds.size());
  for (const Compound& compound : l.system.compounds) {
    l.pools.compounds.push_back({compound.path.c_str(), compound.parent.value});
  }
  lower_atoms(l);
  lower_choices(l);
  lower_connectors(l);
  lower_priorities(l);
  BIP_ASSERT(l.pools.atoms.rows.size() == l.system.atoms.size() &&
                 l.pools.connectors.rows.size() == l.system.connectors.size(),
             "{} atoms and {} connectors", l.pools.atoms.rows.size(), l.pools.connectors.rows.size());
  fold(l.pools.atoms, l.pools.arena);
  fold(l.pools.connectors, l.pools.arena);
  fold(l.pools.port_refs, l.pools.arena);
  fold(l.pools.binds, l.pools.arena);
}

}  // namespace bip::lower
