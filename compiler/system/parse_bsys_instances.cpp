// References, and the rows of instances of .bsys: see parse_bsys_rows.hpp.
#include "compiler/system/parse_bsys_rows.hpp"

namespace bip::system::text {

PortTypeId RowParser::port_type_ref(List& list) {
  return PortTypeId(r_.ref(list, s_.port_types.size(), "port type",
                           [&](std::uint32_t k) -> const std::string& { return s_.port_types[PortTypeId(k)].name; }));
}

CompoundId RowParser::parent(List& list) {
  std::optional<List> in = r_.sub(list, "in");
  if (!in) return {};
  const CompoundId id(r_.ref(*in, s_.compounds.size(), "compound",
                             [&](std::uint32_t k) -> const std::string& { return s_.compounds[CompoundId(k)].path; }));
  r_.close(*in);
  return id;
}

AtomId RowParser::atom_ref(List& list) {
  return AtomId(r_.ref(list, s_.atoms.size(), "atom",
                       [&](std::uint32_t k) -> const std::string& { return s_.atoms[AtomId(k)].path; }));
}

ConnectorId RowParser::connector_ref(List& list) {
  return ConnectorId(r_.ref(list, s_.connectors.size(), "connector",
                            [&](std::uint32_t k) -> const std::string& { return s_.connectors[ConnectorId(k)].path; }));
}

std::vector<DataRef> RowParser::data(List& list) {
  std::vector<DataRef> out;
  std::optional<List> found = r_.sub(list, "data");
  while (found && r_.more(*found)) {
    List one = r_.need(*found, "of");
    const AtomId atom = atom_ref(one);
    if (r_.failed()) return out;
    const std::vector<DataVariable>& variables = s_.atom_types[s_.atoms[atom].type].variables;
    out.push_back({.atom = atom,
                   .variable = r_.ref(one, variables.size(), "slot",
                                      [&](std::uint32_t k) -> const std::string& { return variables[k].name; })});
    r_.close(one);
  }
  if (found) r_.close(*found);
  return out;
}

ExprId RowParser::guard(List& list, const CodeScope& scope) {
  std::optional<List> found = r_.sub(list, "guard");
  if (!found) return {};
  const ExprId id = r_.expr(*found, scope);
  r_.close(*found);
  return id;
}

StmtId RowParser::body(List& list, const char* head, const CodeScope& scope) {
  std::optional<List> found = r_.sub(list, head);
  return found ? r_.body(*found, scope) : StmtId();
}

Compound RowParser::compound(List& list) {
  Compound row;
  r_.row(list, s_.compounds.size());
  row.path = r_.name(list);
  row.type = r_.name(list);
  row.parent = parent(list);
  r_.close(list);
  row.loc = list.loc;
  return row;
}

Atom RowParser::atom(List& list) {
  Atom row;
  r_.row(list, s_.atoms.size());
  row.path = r_.name(list);
  row.type = AtomTypeId(r_.ref(list, s_.atom_types.size(), "atom type", [&](std::uint32_t k) -> const std::string& {
    return s_.atom_types[AtomTypeId(k)].name;
  }));
  row.parent = parent(list);
  if (std::optional<List> args = r_.sub(list, "args")) {
    while (r_.more(*args)) row.args.push_back(r_.literal(r_.next(*args, "a constant")));
    r_.close(*args);
  }
  r_.close(list);
  row.loc = list.loc;
  return row;
}

Choice RowParser::choice(List& list) {
  Choice row;
  r_.row(list, s_.choices.size());
  row.name = r_.name(list);
  List ports = r_.need(list, "ports");
  while (r_.more(ports)) row.ports.push_back(port_ref(r_.next(ports, "a port"), true));
  r_.close(ports);
  r_.close(list);
  return row;
}

Connector RowParser::connector(List& list) {
  Connector row;
  r_.row(list, s_.connectors.size());
  row.path = r_.name(list);
  row.type = ConnectorTypeId(
      r_.ref(list, s_.connector_types.size(), "connector type",
             [&](std::uint32_t k) -> const std::string& { return s_.connector_types[ConnectorTypeId(k)].name; }));
  row.bound = r_.flag(list, "bound");
  row.parent = parent(list);
  List ports = r_.need(list, "ports");
  while (r_.more(ports)) row.ports.push_back(port_ref(r_.next(ports, "a port"), false));
  r_.close(ports);
  row.data = data(list);
  r_.close(list);
  row.loc = list.loc;
  return row;
}

PortRef RowParser::port_ref(std::uint32_t node, bool in_choice) {
  PortRef port;
  std::string_view head;
  List list = r_.open(node, head);
  if (head == "atom") {
    port.atom = atom_ref(list);
    if (r_.failed()) return port;
    const std::vector<Port>& ports = s_.atom_types[s_.atoms[port.atom].type].ports;
    port.port =
        r_.ref(list, ports.size(), "port", [&](std::uint32_t k) -> const std::string& { return ports[k].name; });
  } else if (head == "connector" || head == "maximal") {
    port.kind = PortRef::Kind::Connector;
    port.maximal_only = head == "maximal";
    const auto no_name = [](std::uint32_t) { return std::string_view(); };
    port.connector = in_choice ? ConnectorId(r_.ref(list, kNoNode, "connector", no_name)) : connector_ref(list);
  } else if (head == "choice" && !in_choice) {
    port.kind = PortRef::Kind::Choice;
    port.choice = r_.ref(list, s_.choices.size(), "choice",
                         [&](std::uint32_t k) -> const std::string& { return s_.choices[k].name; });
  } else {
    r_.fail(node, "expected `(atom …)`, `(connector …)`, `(maximal …)` or, but in a choice, `(choice …)`");
  }
  r_.close(list);
  return port;
}

Pattern RowParser::pattern(List& list, const char* head) {
  Pattern p;
  List one = r_.need(list, head);
  if (r_.flag(one, "any")) {
    p.any_connector = true;
  } else {
    p.connector = connector_ref(one);
    if (r_.failed()) return p;
    const std::vector<ConnectorParam>& params = s_.connector_types[s_.connectors[p.connector].type].params;
    p.any_interaction = r_.flag(one, "any");
    if (!p.any_interaction) p.params = refs(one, params, "parameter");
  }
  r_.close(one);
  return p;
}

Priority RowParser::priority(List& list) {
  Priority row;
  r_.row(list, s_.priorities.size());
  row.name = r_.name(list);
  row.parent = parent(list);
  row.low = pattern(list, "low");
  row.high = pattern(list, "high");
  row.data = data(list);
  if (!r_.failed()) row.guard = guard(list, scope_of(s_, row));
  r_.close(list);
  row.loc = list.loc;
  return row;
}

}  // namespace bip::system::text
