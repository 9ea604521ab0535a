// Port, atom and connector types of .bsys: see parse_bsys_rows.hpp.
#include "compiler/system/parse_bsys_rows.hpp"

namespace bip::system::text {

PortType RowParser::port_type(List& list) {
  PortType row;
  r_.row(list, s_.port_types.size());
  row.name = r_.name(list);
  while (std::optional<List> var = r_.sub(list, "var")) {
    Variable v{.name = r_.name(*var), .type = r_.type(*var)};
    r_.close(*var);
    v.loc = var->loc;
    row.variables.push_back(std::move(v));
  }
  r_.close(list);
  row.loc = list.loc;
  return row;
}

std::vector<DataVariable> RowParser::variables(List& list) {
  std::vector<DataVariable> out;
  while (std::optional<List> one = r_.sub(list, "slot")) {
    DataVariable variable;
    r_.row(*one, out.size());
    variable.name = r_.name(*one);
    variable.type = r_.type(*one);
    variable.is_param = r_.flag(*one, "param");
    variable.exported = r_.flag(*one, "export");
    r_.close(*one);
    variable.loc = one->loc;
    out.push_back(std::move(variable));
  }
  return out;
}

AtomType RowParser::atom_type(List& list) {
  AtomType row;
  r_.row(list, s_.atom_types.size());
  row.name = r_.name(list);
  row.variables = variables(list);
  while (std::optional<List> one = r_.sub(list, "port")) {
    Port port;
    r_.row(*one, row.ports.size());
    port.name = r_.name(*one);
    port.type = port_type_ref(*one);
    port.exported = r_.flag(*one, "export");
    if (std::optional<List> extern_list = r_.sub(*one, "extern")) event(*extern_list, port);
    port.variables = sub_refs(*one, "slots", row.variables, "slot");
    r_.close(*one);
    port.loc = one->loc;
    row.ports.push_back(std::move(port));
  }
  while (std::optional<List> one = r_.sub(list, "place")) {
    r_.row(*one, row.places.size());
    row.places.push_back(r_.name(*one));
    r_.close(*one);
  }
  while (std::optional<List> one = r_.sub(list, "clock")) row.clocks.push_back(clock(*one, row));
  const CodeScope scope = scope_of(row);
  row.initial = sub_refs(list, "initial", row.places, "place");
  row.initial_action = body(list, "do", scope);
  row.initial_resume = resume(list, row, scope);
  while (std::optional<List> one = r_.sub(list, "transition")) {
    row.transitions.push_back(transition(*one, row, scope));
  }
  while (std::optional<List> one = r_.sub(list, "priority")) row.priorities.push_back(atom_priority(*one, row, scope));
  while (std::optional<List> one = r_.sub(list, "invariant")) row.invariants.push_back(invariant(*one, row, scope));
  while (std::optional<List> one = r_.sub(list, "merged")) row.merged.push_back(merged(*one, row));
  r_.close(list);
  row.loc = list.loc;
  return row;
}

Transition RowParser::transition(List& list, const AtomType& type, const CodeScope& scope) {
  Transition row;
  r_.row(list, type.transitions.size());
  if (std::optional<List> on = r_.sub(list, "on")) {
    row.port = r_.ref(*on, type.ports.size(), "port",
                      [&](std::uint32_t k) -> const std::string& { return type.ports[k].name; });
    r_.close(*on);
  }
  row.from = sub_refs(list, "from", type.places, "place");
  row.to = sub_refs(list, "to", type.places, "place");
  row.guard = guard(list, scope);
  row.when = when(list, type, scope);
  row.urgency = r_.flag(list, "eager")       ? Urgency::Eager
                : r_.flag(list, "delayable") ? Urgency::Delayable
                                             : Urgency::Lazy;
  row.async = async(list, type);
  row.action = body(list, "do", scope);
  row.resume = resume(list, type, scope);
  r_.close(list);
  row.loc = list.loc;
  return row;
}

AtomPriority RowParser::atom_priority(List& list, const AtomType& type, const CodeScope& scope) {
  AtomPriority row;
  r_.row(list, type.priorities.size());
  row.name = r_.name(list);
  const auto side = [&](const char* head) {
    List one = r_.need(list, head);
    std::uint32_t port = AtomPriority::kAnyPort;
    if (!r_.flag(one, "any"))
      port = r_.ref(one, type.ports.size(), "port",
                    [&](std::uint32_t k) -> const std::string& { return type.ports[k].name; });
    r_.close(one);
    return port;
  };
  row.low = side("low");
  row.high = side("high");
  row.guard = guard(list, scope);
  r_.close(list);
  row.loc = list.loc;
  return row;
}

Invariant RowParser::invariant(List& list, const AtomType& type, const CodeScope& scope) {
  Invariant row;
  r_.row(list, type.invariants.size());
  row.name = r_.name(list);
  const std::uint32_t node = r_.next(list, "always, at or from");
  if (r_.failed()) return row;
  const std::optional<InvariantScope> word = invariant_scope_of(tree_.word(node));
  if (!word) r_.fail(node, "expected always, at or from");
  row.scope = word.value_or(InvariantScope::Always);
  row.places = sub_refs(list, "places", type.places, "place");
  row.condition = guard(list, scope);
  row.when = when(list, type, scope);
  r_.close(list);
  row.loc = list.loc;
  return row;
}

MergedPort RowParser::merged(List& list, const AtomType& type) {
  MergedPort row;
  r_.row(list, type.merged.size());
  row.name = r_.name(list);
  row.type = port_type_ref(list);
  row.ports = sub_refs(list, "ports", type.ports, "port");
  r_.close(list);
  row.loc = list.loc;
  return row;
}

ConnectorType RowParser::connector_type(List& list) {
  ConnectorType row;
  std::uint32_t bind = 0;
  r_.row(list, s_.connector_types.size());
  row.name = r_.name(list);
  while (std::optional<List> one = r_.sub(list, "param")) {
    ConnectorParam param;
    r_.row(*one, row.params.size());
    param.name = r_.name(*one);
    param.type = port_type_ref(*one);
    param.first_bind = bind;
    r_.close(*one);
    param.loc = one->loc;
    if (r_.failed()) return row;
    bind += static_cast<std::uint32_t>(s_.port_types[param.type].variables.size());
    row.params.push_back(std::move(param));
  }
  while (std::optional<List> one = r_.sub(list, "read")) {
    r_.row(*one, row.data_reads.size());
    DataRead read{.path = r_.name(*one), .type = r_.type(*one)};
    r_.close(*one);
    row.data_reads.push_back(std::move(read));
  }
  row.variables = variables(list);
  List define_list = r_.need(list, "define");
  if (!r_.failed()) define(define_list, row);
  r_.close(define_list);
  if (std::optional<List> one = r_.sub(list, "resume")) {
    if (r_.flag(*one, "sync")) row.resume = ResumeMode::Sync;
    r_.close(*one);
  }
  const CodeScope scope = scope_of(s_, row);
  while (std::optional<List> one = r_.sub(list, "clause")) {
    Clause clause;
    r_.row(*one, row.clauses.size());
    clause.params = sub_refs(*one, "params", row.params, "parameter");
    clause.guard = guard(*one, scope);
    clause.up = body(*one, "up", scope);
    clause.down = body(*one, "down", scope);
    r_.close(*one);
    clause.loc = one->loc;
    row.clauses.push_back(std::move(clause));
  }
  if (std::optional<List> one = r_.sub(list, "export")) {
    row.exports = true;
    row.export_name = r_.name(*one);
    row.export_type = port_type_ref(*one);
    row.export_variables = sub_refs(*one, "slots", row.variables, "slot");
    r_.close(*one);
  }
  r_.close(list);
  row.loc = list.loc;
  return row;
}

/// Nodes in preorder: a stack of the groups whose lists are not yet at their end.
void RowParser::define(List& root, ConnectorType& type) {
  struct Group {
    List list;
    std::uint32_t node;
  };
  constexpr std::uint32_t kAbove = 0xffffffffu;
  std::vector<Group> open{{root, kAbove}};
  while (!open.empty() && !r_.failed()) {
    if (!r_.more(open.back().list)) {
      open.pop_back();
      continue;
    }
    const std::uint32_t parent = open.back().node;
    const std::uint32_t element = r_.next(open.back().list, "a group");
    std::string_view head;
    List list = r_.open(element, head);
    if (head != "trigger" && head != "synchron") return r_.fail(element, "expected `(trigger …)` or `(synchron …)`");
    const auto row = static_cast<std::uint32_t>(type.define.size());
    if (parent != kAbove) {
      type.define[parent].children.push_back(row);
    } else if (row != 0) {
      return r_.fail(element, "a define has one group at its top");
    }
    DefineNode node{.is_leaf = false, .trigger = head == "trigger", .param = 0, .children = {}};
    if (r_.more(list) && tree_.nodes[list.at].kind == Node::Kind::Word) {
      node.is_leaf = true;
      node.param = r_.ref(list, type.params.size(), "parameter",
                          [&](std::uint32_t k) -> const std::string& { return type.params[k].name; });
      r_.close(list);
    } else {
      open.push_back({list, row});
    }
    type.define.push_back(std::move(node));
  }
  root.at = kNoNode;
}

}  // namespace bip::system::text
