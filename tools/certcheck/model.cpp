// From the rows of .bsys to the model. Trusts nothing: a row that points nowhere is rejected (`at` throws).
#include "tools/certcheck/model.hpp"

#include <algorithm>

namespace certcheck {

namespace {

// Word `k` of all rows with that head.
std::vector<Text> column(const Tree& list, Text head, std::size_t k) {
  std::vector<Text> words;
  for (const Tree* row : list.all(head)) words.push_back(row->at(k).text);
  return words;
}

void only(const Tree& list, const std::set<Text>& known, std::size_t first, Text owner) {
  for (std::size_t k = first; k < list.items.size(); ++k) {
    // Bounds on clocks would be taken for steps that are always there.
    if (!known.contains(list.items[k].is_list ? list.items[k].head() : list.items[k].text)) throw NotCheckable("`" + std::string(owner) + "` depends on time");
  }
}

class Reader {
 public:
  explicit Reader(Model& model) : m_(model) {}

  void run() {
    if (m_.tree.items.empty() || m_.tree.items[0].head() != "bsys" || m_.tree.items[0].at(1).text != "1") throw Rejected("not `(bsys 1)`");
    for (const Tree* row : m_.tree.all("string")) m_.strings.emplace(row->at(2).text, static_cast<int>(row->at(1).row()));
    for (const Tree* row : m_.tree.all("port-type")) m_.port_types.push_back(column(*row, "var", 2));
    m_.functions = m_.tree.all("function");
    for (const Tree* row : m_.functions) {
      if (!(*row)["ref"].items.empty()) throw NotCheckable("C++ functions get references to variables");
    }
    for (const Tree* row : m_.tree.all("atom-type")) atom_type(*row);
    for (const Tree* row : m_.tree.all("connector-type")) connector_type(*row);
    for (const Tree* row : m_.tree.all("atom")) atom(*row);
    m_.first_port.push_back(m_.nodes.size());
    choices_ = m_.tree.all("choice");
    choice_node_.assign(choices_.size(), kNone);
    for (const Tree* row : m_.tree.all("connector")) connector(*row);
    m_.priorities = m_.tree.all("priority");
    for (std::size_t row = 0; row < m_.nodes.size(); ++row) {
      for (const Edge& edge : m_.nodes[row].children) m_.nodes[edge.node].parents.push_back(row);
    }
  }

 private:
  void atom_type(const Tree& row) {
    AtomType type;
    type.name = row.at(2).text;
    only(row, {"slot", "port", "place", "initial", "do", "transition", "priority", "invariant", "merged"}, 3, type.name);
    for (Text place : column(row, "place", 2)) type.variables.push_back({place, "bool"});
    type.places = type.variables.size();
    for (const Tree* slot : row.all("slot")) type.variables.push_back({slot->at(2).text, slot->at(3).text, slot->has_word("param", 4)});
    const auto places = [&](const Tree& list) {
      const Rows rows = list.rows();
      if (std::any_of(rows.begin(), rows.end(), [&](std::size_t p) { return p >= type.places; })) throw Rejected("a place that there is not");
      return rows;
    };
    for (const Tree* port : row.all("port")) {
      if (!(*port)["extern"].items.empty()) throw NotCheckable("`" + std::string(type.name) + "` waits for events from outside");
      type.ports.push_back({port->at(2).text, port->has_word("export", 4), (*port)["slots"].rows(), {}});
      for (std::size_t& variable : type.ports.back().variables) variable += type.places;
    }
    type.initial = places(row["initial"]);
    type.initial_action = &row["do"];
    type.priorities = row.all("priority");
    for (const Tree* one : row.all("invariant")) type.invariants.push_back({one->at(3).text, places((*one)["places"]), &(*one)["guard"]});
    type.is_automaton = type.initial.size() == 1;
    for (const Tree* t : row.all("transition")) {
      only(*t, {"on", "from", "to", "guard", "do"}, 2, type.name);
      const Rows on = (*t)["on"].rows();
      type.transitions.push_back({on.empty() ? kNone : on[0], places((*t)["from"]), places((*t)["to"]), &(*t)["guard"], &(*t)["do"]});
      if (!on.empty() && on[0] >= type.ports.size()) throw Rejected("a transition of `" + std::string(type.name) + "` has no such port");
      type.is_automaton = type.is_automaton && type.transitions.back().from.size() == 1 && type.transitions.back().to.size() == 1;
    }
    m_.atom_types.push_back(std::move(type));
  }

  void connector_type(const Tree& row) {
    const Tree& exported = row["export"];
    ConnectorType type{{}, column(row, "slot", 3), {}, exported["slots"].rows(), !exported.items.empty(), &row["define"].at(1)};
    for (const Tree* param : row.all("param")) type.params.push_back(param->at(3).row());
    for (const Tree* one : row.all("clause")) type.clauses.push_back({(*one)["params"].rows(), &(*one)["guard"], &(*one)["up"], &(*one)["down"]});
    m_.connector_types.push_back(std::move(type));
  }

  void atom(const Tree& row) {
    const std::size_t type = row.at(3).row();
    m_.first_port.push_back(m_.nodes.size());
    for (const Port& port : m_.atom_types.at(type).ports) {
      m_.nodes.emplace_back().is_step = !port.is_exported;
      m_.atom_of_port.push_back(m_.atoms.size());
    }
    m_.atoms.push_back({row.at(2).text, type, &row["args"]});
  }

  std::size_t add(Kind kind, std::vector<Edge> children) {
    if (children.empty()) throw Rejected("a group of nothing");
    m_.nodes.push_back({kind, std::move(children), {}});
    return m_.nodes.size() - 1;
  }

  Edge binding(const Tree& b) {
    const Text head = b.head();
    const std::size_t row = b.at(1).row();
    if (head == "connector" || head == "maximal") return {m_.connectors.at(row).root, false, head == "maximal"};
    if (head == "atom") {
      const std::size_t port = m_.first_port.at(row) + b.at(2).row();
      return port < m_.first_port.at(row + 1) ? Edge{port} : throw Rejected("a binding to a port that there is not");
    }
    if (head != "choice") throw Rejected("a binding `" + std::string(head) + "`");
    if (choice_node_.at(row) == kNone) {
      const Tree& ports = (*choices_[row])["ports"];
      std::vector<Edge> alternatives;
      // A node of its own for each, so that it is known which one is chosen, whatever they share.
      for (std::size_t k = 1; k < ports.items.size(); ++k) {
        if (ports.items[k].head() == "choice") throw Rejected("a choice in a choice");
        alternatives.push_back({add(Kind::All, {binding(ports.items[k])})});
      }
      choice_node_[row] = add(Kind::Any, std::move(alternatives));
    }
    return {choice_node_[row]};
  }

  // (synchron|trigger CHILD …) or (synchron|trigger PARAM)
  Edge group(const Tree& t, const Connector& c) {
    if (!t.at(1).is_list) return c.params.at(t.items[1].row());
    std::vector<Edge> children;
    Kind kind = Kind::All;
    for (std::size_t k = 1; k < t.items.size(); ++k) {
      children.push_back(group(t.items[k], c));
      children.back().is_trigger = t.items[k].head() == "trigger";
      if (children.back().is_trigger) kind = Kind::Trigger;
    }
    return {add(kind, std::move(children))};
  }

  void connector(const Tree& row) {
    Connector c{row.at(2).text, row.at(3).row(), 0, row["in"].at(1).row(), {}, &row["data"]};
    const ConnectorType& type = m_.connector_types.at(c.type);
    const Tree& ports = row["ports"];
    for (std::size_t k = 1; k < ports.items.size(); ++k) c.params.push_back(binding(ports.items[k]));
    if (c.params.size() != type.params.size()) throw Rejected("a connector with another number of ports than its type");
    const Edge whole = group(*type.define, c);
    c.root = type.define->at(1).is_list ? whole.node : add(Kind::All, {whole});
    m_.nodes[c.root].connector = m_.connectors.size();
    m_.nodes[c.root].is_step = !type.is_exported;
    written_by(c, type);
    m_.connectors.push_back(std::move(c));
  }

  // Transfers that write to the variables of ports.
  void written_by(const Connector& c, const ConnectorType& type) {
    std::vector<std::pair<std::size_t, std::size_t>> variables;  // param, variable
    for (std::size_t p = 0; p < c.params.size(); ++p) {
      for (std::size_t v = 0; v < m_.port_types.at(type.params[p]).size(); ++v) variables.emplace_back(p, v);
    }
    for (const Clause& clause : type.clauses) {
      if (!clause.up->find({"set-bind"}).empty()) throw Rejected("an `up` writes to a port");
      for (const Tree* one : clause.down->find({"set-bind"})) {
        const auto [param, variable] = variables.at(one->at(1).row());
        if (std::find(clause.params.begin(), clause.params.end(), param) == clause.params.end()) {
          throw NotCheckable("a transfer writes to a port that does not take part");
        }
        write(c.params[param].node, variable);
      }
    }
  }
  void write(std::size_t row, std::size_t variable) {
    const Node& node = m_.nodes[row];
    for (const Edge& edge : node.connector == kNone ? node.children : std::vector<Edge>()) write(edge.node, variable);
    if (node.kind != Kind::Port) return;
    const std::size_t atom = m_.atom_of_port[row];
    Port& port = m_.atom_types[m_.atoms[atom].type].ports[row - m_.first_port[atom]];
    port.written.insert(port.variables.at(variable));
  }

  Model& m_;
  std::vector<const Tree*> choices_;
  Rows choice_node_;
};

}  // namespace

std::size_t find_variable(const AtomType& type, Text name, bool is_place) {
  const std::size_t end = is_place ? type.places : type.variables.size();
  std::size_t row = is_place ? 0 : type.places;
  while (row < end && type.variables[row].name != name) ++row;
  return row < end ? row : kNone;
}

void read_model(std::string text, Model& model) {
  model.text = std::move(text);
  model.tree = read_trees(model.text);
  Reader(model).run();
}

}  // namespace certcheck
