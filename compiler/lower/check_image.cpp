// See check_image.hpp. One function per family of tables, in the order in which they are declared (bip/image.hpp).
#include "compiler/lower/check_image.hpp"

#include <algorithm>

#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::lower {

namespace {

using u32 = std::uint32_t;

// Not if it is absent.
[[maybe_unused]] bool is_row(u32 row, u32 size) { return row == rt::kNone || row < size; }
[[maybe_unused]] bool are_rows(const rt::Span<u32>& rows, u32 size) {
  return std::all_of(rows.begin(), rows.end(), [&](u32 row) { return row < size; });
}
[[maybe_unused]] bool is_strictly_sorted(const rt::Span<u32>& rows) {
  return std::adjacent_find(rows.begin(), rows.end(), [](u32 a, u32 b) { return a >= b; }) == rows.end();
}

void check_ports(const rt::Image& image, [[maybe_unused]] const rt::AtomType& type) {
  for ([[maybe_unused]] const rt::Port& port : type.ports) {
    BIP_ASSERT(port.type < image.port_types.size, "port `{}` of atom type `{}` has type {}", port.name, type.name,
               port.type);
    BIP_ASSERT(port.variables.size == image.port_types[port.type].vars.size, "port `{}` of atom type `{}` has {} of {}",
               port.name, type.name, port.variables.size, image.port_types[port.type].vars.size);
    BIP_ASSERT(are_rows(port.variables, type.variables.size), "port `{}` of atom type `{}` shows no variable of it",
               port.name, type.name);
  }
}

void check_time([[maybe_unused]] const rt::Image& image, const rt::AtomType& type) {
  if (type.time == nullptr) return;
  const rt::AtomTime& time = *type.time;
  BIP_ASSERT(time.transitions.size == type.transitions.size, "{} of {} transitions of atom type `{}` have times",
             time.transitions.size, type.transitions.size, type.name);
  BIP_ASSERT(time.invariants.size == type.invariants.size, "{} of {} invariants of atom type `{}` have times",
             time.invariants.size, type.invariants.size, type.name);
  for ([[maybe_unused]] const rt::Clock& clock : time.clocks) {
    BIP_ASSERT(clock.unit > 0 && clock.variable + 2 < type.variables.size, "clock `{}` of atom type `{}`: unit {}",
               clock.name, type.name, clock.unit);
  }
  for (const rt::TransitionTime& transition : time.transitions) {
    BIP_ASSERT(is_row(transition.when.measure, image.codes.size), "code {}", transition.when.measure);
    for ([[maybe_unused]] const rt::Bound& bound : transition.when.bounds) {
      BIP_ASSERT(bound.clock < time.clocks.size && is_row(bound.minus, time.clocks.size) && bound.clock != bound.minus,
                 "a bound on clock {} of atom type `{}`", bound.clock, type.name);
      BIP_ASSERT(is_row(bound.variable, type.variables.size), "a limit in variable {} of atom type `{}`",
                 bound.variable, type.name);
    }
  }
  for ([[maybe_unused]] const rt::EventPort& event : time.events) {
    BIP_ASSERT(event.port < type.ports.size, "events at port {} of atom type `{}`", event.port, type.name);
    BIP_ASSERT(is_row(event.source, image.event_classes.size), "a class {} for events", event.source);
  }
}

void check_atom_types(const rt::Image& image) {
  for (const rt::AtomType& type : image.atom_types) {
    BIP_ASSERT(type.initial.size != 0 && are_rows(type.initial, type.places.size), "atom type `{}` begins nowhere",
               type.name);
    BIP_ASSERT(is_row(type.initial_action, image.codes.size), "code {} of atom type `{}`", type.initial_action,
               type.name);
    BIP_ASSERT(are_rows(type.final_places, type.places.size), "atom type `{}` ends at a place that it lacks",
               type.name);
    check_ports(image, type);
    for ([[maybe_unused]] const rt::Transition& t : type.transitions) {
      BIP_ASSERT(is_row(t.port, type.ports.size), "a transition of atom type `{}` at port {}", type.name, t.port);
      BIP_ASSERT(are_rows(t.from, type.places.size) && are_rows(t.to, type.places.size),
                 "a transition of atom type `{}` between places that it lacks", type.name);
      BIP_ASSERT(is_row(t.guard, image.codes.size) && is_row(t.action, image.codes.size), "codes {} and {} of `{}`",
                 t.guard, t.action, type.name);
    }
    for ([[maybe_unused]] const rt::AtomPriority& p : type.priorities) {
      BIP_ASSERT(is_row(p.low, type.ports.size) && is_row(p.high, type.ports.size) && p.low != p.high,
                 "priority `{}` of atom type `{}` orders ports {} and {}", p.name, type.name, p.low, p.high);
      BIP_ASSERT(is_row(p.guard, image.codes.size), "code {} of priority `{}`", p.guard, p.name);
    }
    for ([[maybe_unused]] const rt::Invariant& i : type.invariants) {
      BIP_ASSERT(are_rows(i.places, type.places.size) && is_row(i.condition, image.codes.size),
                 "invariant `{}` of atom type `{}`", i.name, type.name);
    }
    check_time(image, type);
  }
}

// A tree in preorder: each node but the root is the child of one before it.
void check_define(const rt::ConnectorType& type) {
  BIP_ASSERT(type.define.size != 0, "connector type `{}` defines no interaction", type.name);
  u32 children = 0;
  for (u32 row = 0; row < type.define.size; ++row) {
    const rt::DefineNode& node = type.define[row];
    children += node.children.size;
    BIP_ASSERT(node.is_leaf ? node.param < type.params.size && node.children.size == 0 : node.children.size != 0,
               "node {} of connector type `{}` has {} children", row, type.name, node.children.size);
    BIP_ASSERT(are_rows(node.children, type.define.size) &&
                   std::all_of(node.children.begin(), node.children.end(), [&](u32 child) { return child > row; }),
               "node {} of connector type `{}` is above nodes that come before it", row, type.name);
  }
  BIP_ASSERT(children + 1 == type.define.size, "{} of {} nodes of connector type `{}` have a group", children,
             type.define.size, type.name);
}

void check_connector_types(const rt::Image& image) {
  for (const rt::ConnectorType& type : image.connector_types) {
    check_define(type);
    u32 binds = 0;
    for (const rt::ConnectorParam& param : type.params) {
      BIP_ASSERT(param.type < image.port_types.size && param.first_bind == binds,
                 "parameter `{}` of connector type `{}` binds from {} on, not {}", param.name, type.name,
                 param.first_bind, binds);
      binds += image.port_types[param.type].vars.size;
    }
    for ([[maybe_unused]] const rt::Clause& clause : type.clauses) {
      BIP_ASSERT(
          clause.params.size != 0 && are_rows(clause.params, type.params.size) && is_strictly_sorted(clause.params),
          "a clause of connector type `{}` names {} of {} parameters", type.name, clause.params.size, type.params.size);
      BIP_ASSERT(is_row(clause.guard, image.codes.size) && is_row(clause.up, image.codes.size) &&
                     is_row(clause.down, image.codes.size),
                 "codes {}, {} and {} of connector type `{}`", clause.guard, clause.up, clause.down, type.name);
    }
    BIP_ASSERT(type.exports == (type.export_type != rt::kNone), "connector type `{}` exports type {}", type.name,
               type.export_type);
    BIP_ASSERT(!type.exports || type.export_variables.size == image.port_types[type.export_type].vars.size,
               "connector type `{}` exports {} variables", type.name, type.export_variables.size);
    BIP_ASSERT(are_rows(type.export_variables, type.variables.size),
               "connector type `{}` exports no variable of its own", type.name);
  }
}

void check_atoms(const rt::Image& image) {
  u32 row = 0;
  for (const rt::Atom& atom : image.atoms) {
    BIP_ASSERT(atom.type < image.atom_types.size, "atom {} has type {}", row, atom.type);
    const rt::AtomType& type = image.atom_types[atom.type];
    BIP_ASSERT(atom.first_cell <= image.cell_count && type.variables.size <= image.cell_count - atom.first_cell,
               "atom {} has its {} variables from cell {} on, of {}", row, type.variables.size, atom.first_cell,
               image.cell_count);
    [[maybe_unused]] const auto params = static_cast<u32>(
        std::count_if(type.variables.begin(), type.variables.end(), [](const rt::Var& var) { return var.is_param; }));
    BIP_ASSERT(atom.args <= image.args.size && params <= image.args.size - atom.args,
               "atom {} has its {} arguments from row {} on, of {}", row, params, atom.args, image.args.size);
    ++row;
  }
}

void check_port_ref(const rt::Image& image, const rt::PortRef& ref, [[maybe_unused]] u32 connector) {
  [[maybe_unused]] const int kinds =
      (ref.atom != rt::kNone ? 1 : 0) + (ref.connector != rt::kNone ? 1 : 0) + (ref.choice != rt::kNone ? 1 : 0);
  BIP_ASSERT(kinds == 1, "a parameter of connector {} is bound to {} kinds of ports", connector, kinds);
  if (ref.atom != rt::kNone) {
    BIP_ASSERT(ref.atom < image.atoms.size && ref.port < image.atom_types[image.atoms[ref.atom].type].ports.size,
               "connector {} binds port {} of atom {}", connector, ref.port, ref.atom);
  }
  BIP_ASSERT(is_row(ref.connector, connector), "connector {} binds connector {}, which does not come before it",
             connector, ref.connector);
  BIP_ASSERT(is_row(ref.choice, image.choices.size), "connector {} binds the merged port {}", connector, ref.choice);
}

void check_connectors(const rt::Image& image) {
  u32 row = 0;
  for (const rt::Connector& connector : image.connectors) {
    BIP_ASSERT(connector.type < image.connector_types.size, "connector {} has type {}", row, connector.type);
    const rt::ConnectorType& type = image.connector_types[connector.type];
    BIP_ASSERT(
        connector.first_cell <= image.cell_count && type.variables.size <= image.cell_count - connector.first_cell,
        "connector {} has its variables from cell {} on, of {}", row, connector.first_cell, image.cell_count);
    BIP_ASSERT(connector.ports + std::uint64_t{type.params.size} <= image.port_refs.size,
               "connector {} has its ports from row {} on, of {}", row, connector.ports, image.port_refs.size);
    BIP_ASSERT(connector.binds + std::uint64_t{connector.bind_count} <= image.binds.size,
               "connector {} has its bound variables from row {} on, of {}", row, connector.binds, image.binds.size);
    BIP_ASSERT(connector.parent < image.compounds.size, "connector {} is of compound {}", row, connector.parent);
    for (u32 param = 0; param < type.params.size; ++param)
      check_port_ref(image, image.port_refs[connector.ports + param], row);
    ++row;
  }
  for ([[maybe_unused]] const rt::Bind& bind : image.binds)
    BIP_ASSERT(bind.cell < image.cell_count, "a bound variable in cell {} of {}", bind.cell, image.cell_count);
  for ([[maybe_unused]] const rt::ShownPort& shown : image.shown_ports) {
    BIP_ASSERT(shown.port_ref < image.port_refs.size && shown.compound < image.compounds.size &&
                   (&shown == image.shown_ports.begin() || (&shown)[-1].port_ref < shown.port_ref),
               "the shown name `{}` is of parameter {}", shown.name, shown.port_ref);
  }
  for ([[maybe_unused]] const rt::Choice& choice : image.choices) {
    BIP_ASSERT(choice.ports.size != 0 && std::all_of(choice.ports.begin(), choice.ports.end(),
                                                     [](const rt::PortRef& ref) { return ref.choice == rt::kNone; }),
               "the merged port `{}` has {} ports", choice.name, choice.ports.size);
  }
}

void check_pattern(const rt::Image& image, const rt::Pattern& pattern, [[maybe_unused]] const char* priority) {
  if (pattern.any_connector) {
    BIP_ASSERT(pattern.connector == rt::kNone && pattern.params.size == 0, "priority `{}` names connector {}", priority,
               pattern.connector);
    return;
  }
  BIP_ASSERT(pattern.connector < image.connectors.size, "priority `{}` names connector {}", priority,
             pattern.connector);
  BIP_ASSERT(is_strictly_sorted(pattern.params) &&
                 are_rows(pattern.params, image.connector_types[image.connectors[pattern.connector].type].params.size),
             "priority `{}` names parameters that connector {} lacks", priority, pattern.connector);
}

void check_compounds_and_priorities(const rt::Image& image) {
  for (u32 row = 0; row < image.compounds.size; ++row) {
    BIP_ASSERT(row == 0 ? image.compounds[row].parent == rt::kNone : image.compounds[row].parent < row,
               "compound {} is in compound {}", row, image.compounds[row].parent);
  }
  for (const rt::Priority& priority : image.priorities) {
    BIP_ASSERT(priority.parent < image.compounds.size, "priority `{}` is of compound {}", priority.name,
               priority.parent);
    BIP_ASSERT(is_row(priority.guard, image.codes.size), "code {} of priority `{}`", priority.guard, priority.name);
    BIP_ASSERT(priority.binds + std::uint64_t{priority.bind_count} <= image.binds.size,
               "priority `{}` has its bound variables from row {} on, of {}", priority.name, priority.binds,
               image.binds.size);
    check_pattern(image, priority.low, priority.name);
    check_pattern(image, priority.high, priority.name);
  }
}

}  // namespace

bool check_image(const rt::Image& image) {
  check_atom_types(image);
  check_connector_types(image);
  check_compounds_and_priorities(image);
  check_atoms(image);
  check_connectors(image);
  return true;
}

bool check_lowered(const LoweredSystem& lowered) {
  BIP_ASSERT(lowered.system != nullptr && lowered.codes.size() == lowered.units.size(), "{} codes of {} units",
             lowered.codes.size(), lowered.units.size());
  BIP_ASSERT(lowered.image.codes.data == lowered.codes.data() && lowered.image.codes.size == lowered.codes.size(),
             "the image has {} codes of {}", lowered.image.codes.size, lowered.codes.size());
  BIP_ASSERT(lowered.site_of_expr.size() == lowered.system->code.exprs.size(), "sites of {} of {} expressions",
             lowered.site_of_expr.size(), lowered.system->code.exprs.size());
  BIP_ASSERT(std::all_of(lowered.site_of_expr.begin(), lowered.site_of_expr.end(),
                         [&](u32 site) { return is_row(site, lowered.image.sites.size); }),
             "a site beyond {}", lowered.image.sites.size);
  BIP_ASSERT(lowered.functions.size() == lowered.system->code.functions.size(), "{} FFI functions of {}",
             lowered.functions.size(), lowered.system->code.functions.size());
  for (const CodeUnit& unit : lowered.units) {
    BIP_ASSERT(unit.kind == CodeKind::Guard ? unit.expr.is_valid() : unit.body.is_valid(), "unit `{}` has no code",
               unit.name);
    BIP_ASSERT(unit.owner_row < (unit.owner == CodeOwner::Atom        ? lowered.image.atom_types.size
                                 : unit.owner == CodeOwner::Connector ? lowered.image.connector_types.size
                                                                      : lowered.image.priorities.size),
               "unit `{}` is of row {}", unit.name, unit.owner_row);
  }
  return check_image(lowered.image);
}

}  // namespace bip::lower
