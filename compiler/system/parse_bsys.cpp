// Reads .bsys text: the tree of lists first, then row by row into the tables, then `validate`.
//
// Elements of a row come in the order in which `print` writes them; references point to rows above. Any bytes end in a
// sound System or in "line:column: what is wrong". Linear in the text; memory about 40 bytes an element.
#include <fmt/format.h>

#include <array>

#include "compiler/system/bsys.hpp"
#include "compiler/system/parse_bsys_reader.hpp"
#include "compiler/system/validate_problems.hpp"

namespace bip::system {
namespace {

using namespace text;

class BsysParser {
 public:
  explicit BsysParser(const Tree& tree) : tree_(tree), r_(tree, s_) {}

  Result<System> run() {
    List all = r_.open_bare(0);
    header(all);
    while (r_.more(all)) row(r_.next(all, "a row"));
    if (r_.failed()) return r_.failure();
    const std::vector<Problem> problems = find_problems(s_);
    if (problems.empty()) return std::move(s_);
    const Problem& problem = problems.front();
    const std::vector<std::uint32_t>& rows = rows_[static_cast<std::size_t>(problem.table)];
    const std::size_t offset = problem.row < rows.size() ? tree_.nodes[rows[problem.row]].begin : 0;
    return failure_at(tree_.text, offset, problem.message);
  }

 private:
  void header(List& all) {
    if (!r_.more(all)) return r_.fail(kNoNode, "expected `(bsys 1)`");
    const std::uint32_t node = r_.next(all, "`(bsys 1)`");
    std::string_view head;
    List list = r_.open(node, head);
    if (r_.failed() || head != "bsys" || !r_.flag(list, "1")) return r_.fail(node, "the first row is `(bsys 1)`");
    r_.close(list);
  }

  void row(std::uint32_t node) {
    std::string_view head;
    List list = r_.open(node, head);
    if (r_.failed()) return;
    if (head == "file") {
      r_.row(list, s_.files.size());
      s_.files.push_back(r_.quoted(list));
    } else if (head == "string") {
      r_.row(list, s_.code.strings.size());
      if (!r_.add_string(r_.quoted(list)) && !r_.failed()) r_.fail(node, "this string has a row already");
    } else if (head == "port-type") {
      push(Table::PortTypes, node, s_.port_types, port_type(list));
    } else if (head == "atom-type") {
      push(Table::AtomTypes, node, s_.atom_types, atom_type(list));
    } else if (head == "connector-type") {
      push(Table::ConnectorTypes, node, s_.connector_types, connector_type(list));
    } else if (head == "compound") {
      push(Table::Compounds, node, s_.compounds, compound(list));
    } else if (head == "atom") {
      push(Table::Atoms, node, s_.atoms, atom(list));
    } else if (head == "connector") {
      push(Table::Connectors, node, s_.connectors, connector(list));
    } else if (head == "priority") {
      push(Table::Priorities, node, s_.priorities, priority(list));
    } else {
      r_.fail(node, "no row begins with this word");
    }
    r_.close(list);
  }
  template <class Rows, class Row>
  void push(Table table, std::uint32_t node, Rows& rows, Row row) {
    rows_[static_cast<std::size_t>(table)].push_back(node);
    rows.push(std::move(row));
  }

  // ---- references --------------------------------------------------------------------------------------------
  PortTypeId port_type_ref(List& list) {
    return PortTypeId(r_.ref(list, s_.port_types.size(), "port type",
                             [&](std::uint32_t k) -> const std::string& { return s_.port_types[PortTypeId(k)].name; }));
  }
  /// The rest of the list as rows of `rows`, whose elements have a name or are one.
  template <class Rows>
  std::vector<std::uint32_t> refs(List& list, const Rows& rows, const char* what) {
    std::vector<std::uint32_t> out;
    while (r_.more(list))
      out.push_back(r_.ref(list, rows.size(), what, [&](std::uint32_t k) -> const std::string& {
        if constexpr (requires { rows[k].name; }) {
          return rows[k].name;
        } else {
          return rows[k];
        }
      }));
    r_.close(list);
    return out;
  }
  template <class Rows>
  std::vector<std::uint32_t> sub_refs(List& list, const char* head, const Rows& rows, const char* what) {
    std::optional<List> found = r_.sub(list, head);
    return found ? refs(*found, rows, what) : std::vector<std::uint32_t>();
  }
  CompoundId parent(List& list) {
    std::optional<List> in = r_.sub(list, "in");
    if (!in) return {};
    const CompoundId id(r_.ref(*in, s_.compounds.size(), "compound",
                               [&](std::uint32_t k) -> const std::string& { return s_.compounds[CompoundId(k)].path; }));
    r_.close(*in);
    return id;
  }
  AtomId atom_ref(List& list) {
    return AtomId(r_.ref(list, s_.atoms.size(), "atom",
                         [&](std::uint32_t k) -> const std::string& { return s_.atoms[AtomId(k)].path; }));
  }
  ConnectorId connector_ref(List& list) {
    return ConnectorId(r_.ref(list, s_.connectors.size(), "connector", [&](std::uint32_t k) -> const std::string& {
      return s_.connectors[ConnectorId(k)].path;
    }));
  }
  std::vector<DataRef> data(List& list) {
    std::vector<DataRef> out;
    std::optional<List> found = r_.sub(list, "data");
    while (found && r_.more(*found)) {
      List one = r_.need(*found, "of");
      const AtomId atom = atom_ref(one);
      if (r_.failed()) return out;
      const std::vector<Slot>& slots = s_.atom_types[s_.atoms[atom].type].slots;
      out.push_back({.atom = atom, .slot = r_.ref(one, slots.size(), "slot", [&](std::uint32_t k) -> const std::string& {
                       return slots[k].name;
                     })});
      r_.close(one);
    }
    if (found) r_.close(*found);
    return out;
  }

  // ---- code --------------------------------------------------------------------------------------------------
  ExprId guard(List& list, const CodeScope& scope) {
    std::optional<List> found = r_.sub(list, "guard");
    if (!found) return {};
    const ExprId id = r_.expr(*found, scope);
    r_.close(*found);
    return id;
  }
  StmtId body(List& list, const char* head, const CodeScope& scope) {
    std::optional<List> found = r_.sub(list, head);
    return found ? r_.body(*found, scope) : StmtId();
  }

  // ---- types -------------------------------------------------------------------------------------------------
  PortType port_type(List& list) {
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
  std::vector<Slot> slots(List& list) {
    std::vector<Slot> out;
    while (std::optional<List> one = r_.sub(list, "slot")) {
      Slot slot;
      r_.row(*one, out.size());
      slot.name = r_.name(*one);
      slot.type = r_.type(*one);
      slot.is_param = r_.flag(*one, "param");
      slot.exported = r_.flag(*one, "export");
      r_.close(*one);
      slot.loc = one->loc;
      out.push_back(std::move(slot));
    }
    return out;
  }

  AtomType atom_type(List& list) {
    AtomType row;
    r_.row(list, s_.atom_types.size());
    row.name = r_.name(list);
    row.slots = slots(list);
    while (std::optional<List> one = r_.sub(list, "port")) {
      Port port;
      r_.row(*one, row.ports.size());
      port.name = r_.name(*one);
      port.type = port_type_ref(*one);
      port.exported = r_.flag(*one, "export");
      port.slots = sub_refs(*one, "slots", row.slots, "slot");
      r_.close(*one);
      port.loc = one->loc;
      row.ports.push_back(std::move(port));
    }
    while (std::optional<List> one = r_.sub(list, "place")) {
      r_.row(*one, row.places.size());
      row.places.push_back(r_.name(*one));
      r_.close(*one);
    }
    const CodeScope scope = scope_of(row);
    row.initial = sub_refs(list, "initial", row.places, "place");
    row.initial_action = body(list, "do", scope);
    while (std::optional<List> one = r_.sub(list, "transition")) {
      row.transitions.push_back(transition(*one, row, scope));
    }
    r_.close(list);
    row.loc = list.loc;
    return row;
  }
  Transition transition(List& list, const AtomType& type, const CodeScope& scope) {
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
    row.action = body(list, "do", scope);
    r_.close(list);
    row.loc = list.loc;
    return row;
  }

  ConnectorType connector_type(List& list) {
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
    row.slots = slots(list);
    List define_list = r_.need(list, "define");
    if (!r_.failed()) define(define_list, row);
    r_.close(define_list);
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
      row.export_slots = sub_refs(*one, "slots", row.slots, "slot");
      r_.close(*one);
    }
    r_.close(list);
    row.loc = list.loc;
    return row;
  }
  /// Nodes in preorder: a stack of the groups whose lists are not yet at their end.
  void define(List& root, ConnectorType& type) {
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

  // ---- instances ---------------------------------------------------------------------------------------------
  Compound compound(List& list) {
    Compound row;
    r_.row(list, s_.compounds.size());
    row.path = r_.name(list);
    row.type = r_.name(list);
    row.parent = parent(list);
    r_.close(list);
    row.loc = list.loc;
    return row;
  }
  Atom atom(List& list) {
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
  Connector connector(List& list) {
    Connector row;
    r_.row(list, s_.connectors.size());
    row.path = r_.name(list);
    row.type = ConnectorTypeId(r_.ref(list, s_.connector_types.size(), "connector type",
                                      [&](std::uint32_t k) -> const std::string& {
                                        return s_.connector_types[ConnectorTypeId(k)].name;
                                      }));
    row.bound = r_.flag(list, "bound");
    row.parent = parent(list);
    List ports = r_.need(list, "ports");
    while (r_.more(ports)) row.ports.push_back(port_ref(r_.next(ports, "a port")));
    r_.close(ports);
    row.data = data(list);
    r_.close(list);
    row.loc = list.loc;
    return row;
  }
  PortRef port_ref(std::uint32_t node) {
    PortRef port;
    std::string_view head;
    List list = r_.open(node, head);
    if (head == "atom") {
      port.atom = atom_ref(list);
      if (r_.failed()) return port;
      const std::vector<Port>& ports = s_.atom_types[s_.atoms[port.atom].type].ports;
      port.port = r_.ref(list, ports.size(), "port", [&](std::uint32_t k) -> const std::string& { return ports[k].name; });
    } else if (head == "connector" || head == "maximal") {
      port.kind = PortRef::Kind::Connector;
      port.maximal_only = head == "maximal";
      port.connector = connector_ref(list);
    } else {
      r_.fail(node, "expected `(atom …)`, `(connector …)` or `(maximal …)`");
    }
    r_.close(list);
    return port;
  }
  Pattern pattern(List& list, const char* head) {
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
  Priority priority(List& list) {
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

  const Tree& tree_;
  System s_;
  Reader r_;
  std::array<std::vector<std::uint32_t>, kTables> rows_;
};

}  // namespace

Result<System> parse_bsys(std::string_view text) {
  Result<Tree> tree = read_tree(text);
  if (!tree) return Failure{tree.error()};
  return BsysParser(*tree).run();
}

}  // namespace bip::system
