// See bsys_row_parser.hpp: references, time, types, instances.
#include "compiler/system/bsys_row_parser.hpp"

#include <charconv>

namespace bip::system::text {

// ---- references and what rows share

PortTypeId BsysRowParser::port_type_ref(List& list) {
  return PortTypeId(
      reader_.ref(list, system_.port_types.size(), "port type",
                  [&](std::uint32_t k) -> const std::string& { return system_.port_types[PortTypeId(k)].name; }));
}

CompoundId BsysRowParser::parent(List& list) {
  std::optional<List> in = reader_.sub(list, "in");
  if (!in) return {};
  const CompoundId id = compound_ref(*in);
  reader_.close(*in);
  return id;
}

CompoundId BsysRowParser::compound_ref(List& list) {
  return CompoundId(reader_.ref(list, system_.compounds.size(), "compound", [&](std::uint32_t k) -> const std::string& {
    return system_.compounds[CompoundId(k)].path;
  }));
}

AtomId BsysRowParser::atom_ref(List& list) {
  return AtomId(reader_.ref(list, system_.atoms.size(), "atom",
                            [&](std::uint32_t k) -> const std::string& { return system_.atoms[AtomId(k)].path; }));
}

ConnectorId BsysRowParser::connector_ref(List& list) {
  return ConnectorId(
      reader_.ref(list, system_.connectors.size(), "connector",
                  [&](std::uint32_t k) -> const std::string& { return system_.connectors[ConnectorId(k)].path; }));
}

std::vector<DataRef> BsysRowParser::data(List& list) {
  std::vector<DataRef> out;
  std::optional<List> found = reader_.sub(list, "data");
  while (found && reader_.more(*found)) {
    List row_list = reader_.need(*found, "of");
    const AtomId atom = atom_ref(row_list);
    if (reader_.failed()) return out;
    const std::vector<DataVariable>& variables = system_.atom_types[system_.atoms[atom].type].variables;
    out.push_back({.atom = atom,
                   .variable = reader_.ref(row_list, variables.size(), "slot",
                                           [&](std::uint32_t k) -> const std::string& { return variables[k].name; })});
    reader_.close(row_list);
  }
  if (found) reader_.close(*found);
  return out;
}

ExprId BsysRowParser::guard(List& list, const CodeScope& scope) {
  std::optional<List> found = reader_.sub(list, "guard");
  if (!found) return {};
  const ExprId id = reader_.expr(*found, scope);
  reader_.close(*found);
  return id;
}

StmtId BsysRowParser::body(List& list, const char* head, const CodeScope& scope) {
  std::optional<List> found = reader_.sub(list, head);
  return found ? reader_.body(*found, scope) : StmtId();
}

// ---- time: clocks, bounds, `resume`, `async`, events

namespace {

// "5000000ns"
std::int64_t ticks(BsysReader& r, const Tree& tree, List& list) {
  std::int64_t value = 0;
  const std::uint32_t node = r.next(list, "a time in ns");
  if (r.failed()) return value;
  const std::string_view word = tree.nodes[node].kind == Node::Kind::Word ? tree.word(node) : std::string_view();
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || word.substr(static_cast<std::size_t>(end - word.data())) != "ns")
    r.fail(node, "expected a time such as 5000000ns");
  return value;
}

}  // namespace

Clock BsysRowParser::clock(List& list, const AtomType& type) {
  Clock row;
  reader_.row(list, type.clocks.size());
  row.name = reader_.name(list);
  row.unit = ticks(reader_, tree_, list);
  row.variable = reader_.ref(list, type.variables.size(), "slot",
                             [&](std::uint32_t k) -> const std::string& { return type.variables[k].name; });
  reader_.close(list);
  row.loc = list.loc;
  return row;
}

TimeGuard BsysRowParser::when(List& list, const AtomType& type, const CodeScope& scope) {
  TimeGuard row;
  const auto clock_ref = [&](List& from) {
    return reader_.ref(from, type.clocks.size(), "clock",
                       [&](std::uint32_t k) -> const std::string& { return type.clocks[k].name; });
  };
  while (std::optional<List> row_list = reader_.sub(list, "bound")) {
    Bound bound;
    const BoundOp ops[] = {BoundOp::Lt, BoundOp::Le, BoundOp::Gt, BoundOp::Ge, BoundOp::Eq};
    bool is_known = false;
    for (const BoundOp op : ops) {
      if (is_known || !reader_.flag(*row_list, name_of(op))) continue;
      bound.op = op;
      is_known = true;
    }
    if (!is_known) reader_.fail(row_list->node, "expected lt, le, gt, ge or eq");
    bound.clock = clock_ref(*row_list);
    if (std::optional<List> minus = reader_.sub(*row_list, "minus")) {
      bound.minus = clock_ref(*minus);
      reader_.close(*minus);
    }
    if (std::optional<List> variable = reader_.sub(*row_list, "slot")) {
      bound.variable = reader_.ref(*variable, type.variables.size(), "slot",
                                   [&](std::uint32_t k) -> const std::string& { return type.variables[k].name; });
      reader_.close(*variable);
    } else {
      bound.ticks = ticks(reader_, tree_, *row_list);
    }
    reader_.close(*row_list);
    bound.loc = row_list->loc;
    row.bounds.push_back(bound);
  }
  row.measure = body(list, "measure", scope);
  return row;
}

Resume BsysRowParser::resume(List& list, const AtomType& type, const CodeScope& scope) {
  Resume row;
  std::optional<List> row_list = reader_.sub(list, "resume");
  if (!row_list) return row;
  row.present = true;
  row.guard = guard(*row_list, scope);
  row.when = when(*row_list, type, scope);
  reader_.close(*row_list);
  row.loc = row_list->loc;
  return row;
}

Async BsysRowParser::async(List& list, const AtomType& type) {
  Async row;
  std::optional<List> row_list = reader_.sub(list, "async");
  if (!row_list) return row;
  row.present = true;
  if (reader_.more(*row_list)) row.budget = ticks(reader_, tree_, *row_list);
  if (std::optional<List> port = reader_.sub(*row_list, "overrun")) {
    row.overrun = reader_.ref(*port, type.ports.size(), "port",
                              [&](std::uint32_t k) -> const std::string& { return type.ports[k].name; });
    reader_.close(*port);
  }
  reader_.close(*row_list);
  return row;
}

void BsysRowParser::event(List& list, Port& port) {
  port.external = true;
  if (reader_.flag(list, "ignore")) port.policy = EventPolicy::Ignore;
  else if (reader_.flag(list, "error")) port.policy = EventPolicy::Error;
  else if (!reader_.flag(list, "remember")) reader_.fail(list.node, "expected remember, ignore or error");
  port.event_class = reader_.quoted(list);
  reader_.close(list);
}

// ---- types

PortType BsysRowParser::port_type(List& list) {
  PortType row;
  reader_.row(list, system_.port_types.size());
  row.name = reader_.name(list);
  while (std::optional<List> var = reader_.sub(list, "var")) {
    Variable v{.name = reader_.name(*var), .type = reader_.type(*var)};
    reader_.close(*var);
    v.loc = var->loc;
    row.variables.push_back(std::move(v));
  }
  reader_.close(list);
  row.loc = list.loc;
  return row;
}

std::vector<DataVariable> BsysRowParser::variables(List& list) {
  std::vector<DataVariable> out;
  while (std::optional<List> row_list = reader_.sub(list, "slot")) {
    DataVariable variable;
    reader_.row(*row_list, out.size());
    variable.name = reader_.name(*row_list);
    variable.type = reader_.type(*row_list);
    variable.is_param = reader_.flag(*row_list, "param");
    variable.exported = reader_.flag(*row_list, "export");
    reader_.close(*row_list);
    variable.loc = row_list->loc;
    out.push_back(std::move(variable));
  }
  return out;
}

AtomType BsysRowParser::atom_type(List& list) {
  AtomType row;
  reader_.row(list, system_.atom_types.size());
  row.name = reader_.name(list);
  row.variables = variables(list);
  while (std::optional<List> row_list = reader_.sub(list, "port")) {
    Port port;
    reader_.row(*row_list, row.ports.size());
    port.name = reader_.name(*row_list);
    port.type = port_type_ref(*row_list);
    port.exported = reader_.flag(*row_list, "export");
    if (std::optional<List> extern_list = reader_.sub(*row_list, "extern")) event(*extern_list, port);
    port.variables = sub_refs(*row_list, "slots", row.variables, "slot");
    reader_.close(*row_list);
    port.loc = row_list->loc;
    row.ports.push_back(std::move(port));
  }
  while (std::optional<List> row_list = reader_.sub(list, "place")) {
    reader_.row(*row_list, row.places.size());
    row.places.push_back(reader_.name(*row_list));
    reader_.close(*row_list);
  }
  while (std::optional<List> row_list = reader_.sub(list, "clock")) row.clocks.push_back(clock(*row_list, row));
  if (std::optional<List> draws = reader_.sub(list, "draws")) {
    row.draws = reader_.ref(*draws, row.variables.size(), "slot",
                            [&](std::uint32_t k) -> const std::string& { return row.variables[k].name; });
    reader_.close(*draws);
  }
  const CodeScope scope = scope_of(row);
  row.initial = sub_refs(list, "initial", row.places, "place");
  row.initial_action = body(list, "do", scope);
  row.initial_resume = resume(list, row, scope);
  row.final_places = sub_refs(list, "final", row.places, "place");
  while (std::optional<List> row_list = reader_.sub(list, "transition")) {
    row.transitions.push_back(transition(*row_list, row, scope));
  }
  while (std::optional<List> row_list = reader_.sub(list, "priority"))
    row.priorities.push_back(atom_priority(*row_list, row, scope));
  while (std::optional<List> row_list = reader_.sub(list, "invariant"))
    row.invariants.push_back(invariant(*row_list, row, scope));
  while (std::optional<List> row_list = reader_.sub(list, "merged")) row.merged.push_back(merged(*row_list, row));
  reader_.close(list);
  row.loc = list.loc;
  return row;
}

Transition BsysRowParser::transition(List& list, const AtomType& type, const CodeScope& scope) {
  Transition row;
  reader_.row(list, type.transitions.size());
  if (std::optional<List> on = reader_.sub(list, "on")) {
    row.port = reader_.ref(*on, type.ports.size(), "port",
                           [&](std::uint32_t k) -> const std::string& { return type.ports[k].name; });
    reader_.close(*on);
  }
  row.from = sub_refs(list, "from", type.places, "place");
  row.to = sub_refs(list, "to", type.places, "place");
  row.guard = guard(list, scope);
  row.when = when(list, type, scope);
  row.urgency = reader_.flag(list, "eager")       ? Urgency::Eager
                : reader_.flag(list, "delayable") ? Urgency::Delayable
                                                  : Urgency::Lazy;
  row.async = async(list, type);
  row.action = body(list, "do", scope);
  row.resume = resume(list, type, scope);
  row.weight = weight(list, type);
  reader_.close(list);
  row.loc = list.loc;
  return row;
}

Weight BsysRowParser::weight(List& list, const AtomType& type) {
  Weight row;
  std::optional<List> found = reader_.sub(list, "weight");
  if (!found) return row;
  if (std::optional<List> param = reader_.sub(*found, "slot")) {
    row.param = reader_.ref(*param, type.variables.size(), "slot",
                            [&](std::uint32_t k) -> const std::string& { return type.variables[k].name; });
    reader_.close(*param);
  } else {
    row.value = number(*found);
  }
  reader_.close(*found);
  return row;
}

double BsysRowParser::number(List& list) {
  const Value value = reader_.literal(reader_.next(list, "a number"));
  return value.type == Type::Int ? static_cast<double>(value.int_value) : value.float_value;
}

AtomPriority BsysRowParser::atom_priority(List& list, const AtomType& type, const CodeScope& scope) {
  AtomPriority row;
  reader_.row(list, type.priorities.size());
  row.name = reader_.name(list);
  const auto side = [&](const char* head) {
    List row_list = reader_.need(list, head);
    std::uint32_t port = AtomPriority::kAnyPort;
    if (!reader_.flag(row_list, "any"))
      port = reader_.ref(row_list, type.ports.size(), "port",
                         [&](std::uint32_t k) -> const std::string& { return type.ports[k].name; });
    reader_.close(row_list);
    return port;
  };
  row.low = side("low");
  row.high = side("high");
  row.guard = guard(list, scope);
  reader_.close(list);
  row.loc = list.loc;
  return row;
}

Invariant BsysRowParser::invariant(List& list, const AtomType& type, const CodeScope& scope) {
  Invariant row;
  reader_.row(list, type.invariants.size());
  row.name = reader_.name(list);
  const std::uint32_t node = reader_.next(list, "always, at or from");
  if (reader_.failed()) return row;
  const std::optional<InvariantScope> word = invariant_scope_of(tree_.word(node));
  if (!word) reader_.fail(node, "expected always, at or from");
  row.scope = word.value_or(InvariantScope::Always);
  row.places = sub_refs(list, "places", type.places, "place");
  row.condition = guard(list, scope);
  row.when = when(list, type, scope);
  reader_.close(list);
  row.loc = list.loc;
  return row;
}

MergedPort BsysRowParser::merged(List& list, const AtomType& type) {
  MergedPort row;
  reader_.row(list, type.merged.size());
  row.name = reader_.name(list);
  row.type = port_type_ref(list);
  row.ports = sub_refs(list, "ports", type.ports, "port");
  reader_.close(list);
  row.loc = list.loc;
  return row;
}

ConnectorType BsysRowParser::connector_type(List& list) {
  ConnectorType row;
  std::uint32_t bind = 0;
  reader_.row(list, system_.connector_types.size());
  row.name = reader_.name(list);
  while (std::optional<List> row_list = reader_.sub(list, "param")) {
    ConnectorParam param;
    reader_.row(*row_list, row.params.size());
    param.name = reader_.name(*row_list);
    param.type = port_type_ref(*row_list);
    param.first_bind = bind;
    reader_.close(*row_list);
    param.loc = row_list->loc;
    if (reader_.failed()) return row;
    bind += static_cast<std::uint32_t>(system_.port_types[param.type].variables.size());
    row.params.push_back(std::move(param));
  }
  while (std::optional<List> row_list = reader_.sub(list, "read")) {
    reader_.row(*row_list, row.data_reads.size());
    DataRead read{.path = reader_.name(*row_list), .type = reader_.type(*row_list)};
    reader_.close(*row_list);
    row.data_reads.push_back(std::move(read));
  }
  row.variables = variables(list);
  List define_list = reader_.need(list, "define");
  if (!reader_.failed()) define(define_list, row);
  reader_.close(define_list);
  if (std::optional<List> row_list = reader_.sub(list, "resume")) {
    if (reader_.flag(*row_list, "sync")) row.resume = ResumeMode::Sync;
    reader_.close(*row_list);
  }
  const CodeScope scope = scope_of(system_, row);
  while (std::optional<List> row_list = reader_.sub(list, "clause")) {
    Clause clause;
    reader_.row(*row_list, row.clauses.size());
    clause.params = sub_refs(*row_list, "params", row.params, "parameter");
    clause.guard = guard(*row_list, scope);
    clause.up = body(*row_list, "up", scope);
    clause.down = body(*row_list, "down", scope);
    reader_.close(*row_list);
    clause.loc = row_list->loc;
    row.clauses.push_back(std::move(clause));
  }
  if (std::optional<List> row_list = reader_.sub(list, "export")) {
    row.exports = true;
    row.export_name = reader_.name(*row_list);
    row.export_type = port_type_ref(*row_list);
    row.export_variables = sub_refs(*row_list, "slots", row.variables, "slot");
    reader_.close(*row_list);
  }
  reader_.close(list);
  row.loc = list.loc;
  return row;
}

/// Nodes in preorder: a stack of the groups whose lists are not yet at their end.
void BsysRowParser::define(List& root, ConnectorType& type) {
  struct Group {
    List list;
    std::uint32_t node;
  };
  constexpr std::uint32_t kAbove = 0xffffffffu;
  std::vector<Group> open{{root, kAbove}};
  while (!open.empty() && !reader_.failed()) {
    if (!reader_.more(open.back().list)) {
      open.pop_back();
      continue;
    }
    const std::uint32_t parent = open.back().node;
    const std::uint32_t element = reader_.next(open.back().list, "a group");
    std::string_view head;
    List list = reader_.open(element, head);
    if (head != "trigger" && head != "synchron")
      return reader_.fail(element, "expected `(trigger …)` or `(synchron …)`");
    const auto row = static_cast<std::uint32_t>(type.define.size());
    if (parent != kAbove) {
      type.define[parent].children.push_back(row);
    } else if (row != 0) {
      return reader_.fail(element, "a define has one group at its top");
    }
    DefineNode node{.is_leaf = false, .trigger = head == "trigger", .param = 0, .children = {}};
    if (reader_.more(list) && tree_.nodes[list.at].kind == Node::Kind::Word) {
      node.is_leaf = true;
      node.param = reader_.ref(list, type.params.size(), "parameter",
                               [&](std::uint32_t k) -> const std::string& { return type.params[k].name; });
      reader_.close(list);
    } else {
      open.push_back({list, row});
    }
    type.define.push_back(std::move(node));
  }
  root.at = kNoNode;
}

// ---- instances

Compound BsysRowParser::compound(List& list) {
  Compound row;
  reader_.row(list, system_.compounds.size());
  row.path = reader_.name(list);
  row.type = reader_.name(list);
  row.parent = parent(list);
  reader_.close(list);
  row.loc = list.loc;
  return row;
}

Atom BsysRowParser::atom(List& list) {
  Atom row;
  reader_.row(list, system_.atoms.size());
  row.path = reader_.name(list);
  row.type =
      AtomTypeId(reader_.ref(list, system_.atom_types.size(), "atom type", [&](std::uint32_t k) -> const std::string& {
        return system_.atom_types[AtomTypeId(k)].name;
      }));
  row.parent = parent(list);
  if (std::optional<List> args = reader_.sub(list, "args")) {
    while (reader_.more(*args)) row.args.push_back(reader_.literal(reader_.next(*args, "a constant")));
    reader_.close(*args);
  }
  reader_.close(list);
  row.loc = list.loc;
  return row;
}

Choice BsysRowParser::choice(List& list) {
  Choice row;
  reader_.row(list, system_.choices.size());
  row.name = reader_.name(list);
  List ports = reader_.need(list, "ports");
  while (reader_.more(ports)) row.ports.push_back(port_ref(reader_.next(ports, "a port"), PortPlace::Choice));
  reader_.close(ports);
  reader_.close(list);
  return row;
}

Connector BsysRowParser::connector(List& list) {
  Connector row;
  reader_.row(list, system_.connectors.size());
  row.path = reader_.name(list);
  row.type = ConnectorTypeId(reader_.ref(
      list, system_.connector_types.size(), "connector type",
      [&](std::uint32_t k) -> const std::string& { return system_.connector_types[ConnectorTypeId(k)].name; }));
  row.bound = reader_.flag(list, "bound");
  row.parent = parent(list);
  List ports = reader_.need(list, "ports");
  while (reader_.more(ports)) row.ports.push_back(port_ref(reader_.next(ports, "a port"), PortPlace::Connector));
  reader_.close(ports);
  while (std::optional<List> shown = reader_.sub(list, "shown")) row.shown.push_back(shown_port(*shown, row.type));
  row.data = data(list);
  if (std::optional<List> found = reader_.sub(list, "weight")) {
    row.weight = number(*found);
    reader_.close(*found);
  }
  reader_.close(list);
  row.loc = list.loc;
  return row;
}

ShownPort BsysRowParser::shown_port(List& list, ConnectorTypeId type) {
  ShownPort row;
  if (reader_.failed()) return row;
  const auto& params = system_.connector_types[type].params;
  row.param = reader_.ref(list, params.size(), "parameter",
                          [&](std::uint32_t k) -> const std::string& { return params[k].name; });
  row.compound = compound_ref(list);
  row.name = reader_.name(list);
  reader_.close(list);
  return row;
}

PortRef BsysRowParser::port_ref(std::uint32_t node, PortPlace place) {
  PortRef port;
  std::string_view head;
  List list = reader_.open(node, head);
  if (head == "atom") {
    port.atom = atom_ref(list);
    if (reader_.failed()) return port;
    const std::vector<Port>& ports = system_.atom_types[system_.atoms[port.atom].type].ports;
    port.port =
        reader_.ref(list, ports.size(), "port", [&](std::uint32_t k) -> const std::string& { return ports[k].name; });
  } else if (head == "connector" || head == "maximal") {
    port.kind = PortRef::Kind::Connector;
    port.maximal_only = head == "maximal";
    const auto no_name = [](std::uint32_t) { return std::string_view(); };
    port.connector = place == PortPlace::Choice ? ConnectorId(reader_.ref(list, kNoNode, "connector", no_name))
                                                : connector_ref(list);
  } else if (head == "choice" && place == PortPlace::Connector) {
    port.kind = PortRef::Kind::Choice;
    port.choice = reader_.ref(list, system_.choices.size(), "choice",
                              [&](std::uint32_t k) -> const std::string& { return system_.choices[k].name; });
  } else {
    reader_.fail(node, "expected `(atom …)`, `(connector …)`, `(maximal …)` or, but in a choice, `(choice …)`");
  }
  reader_.close(list);
  return port;
}

Pattern BsysRowParser::pattern(List& list, const char* head) {
  Pattern p;
  List row_list = reader_.need(list, head);
  if (reader_.flag(row_list, "any")) {
    p.any_connector = true;
  } else {
    p.connector = connector_ref(row_list);
    if (reader_.failed()) return p;
    const std::vector<ConnectorParam>& params = system_.connector_types[system_.connectors[p.connector].type].params;
    p.any_interaction = reader_.flag(row_list, "any");
    if (!p.any_interaction) p.params = refs(row_list, params, "parameter");
  }
  reader_.close(row_list);
  return p;
}

Priority BsysRowParser::priority(List& list) {
  Priority row;
  reader_.row(list, system_.priorities.size());
  row.name = reader_.name(list);
  row.parent = parent(list);
  row.low = pattern(list, "low");
  row.high = pattern(list, "high");
  row.data = data(list);
  if (!reader_.failed()) row.guard = guard(list, scope_of(system_, row));
  reader_.close(list);
  row.loc = list.loc;
  return row;
}

}  // namespace bip::system::text
