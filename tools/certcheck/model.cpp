// From the rows of .bsys to the model. Trusts nothing: a row that points nowhere is rejected (`at` throws).
#include "tools/certcheck/model.hpp"

#include <algorithm>
#include <string_view>

namespace certcheck {

Rows rows_of(const Tree* list) {
  Rows rows;
  for (std::size_t k = 1; list != nullptr && k < list->items.size(); ++k) rows.push_back(list->items[k].row());
  return rows;
}

namespace {

bool has_word(const Tree& list, std::string_view word) {
  return std::any_of(list.items.begin(), list.items.end(), [&](const Tree& item) { return !item.is_list && !item.is_string && item.text == word; });
}

class Reader {
 public:
  explicit Reader(Model& model) : m_(model) {}

  void run() {
    if (m_.trees.empty() || m_.trees[0].head() != "bsys" || m_.trees[0].items.at(1).text != "1") throw Rejected("not `(bsys 1)`");
    std::vector<const Tree*> connectors;
    for (const Tree& row : m_.trees) {
      const std::string& head = row.head();
      if (head == "string") m_.strings.emplace(row.items.at(2).text, static_cast<int>(row.items.at(1).row()));
      else if (head == "port-type") port_type(row);
      else if (head == "priority") m_.priorities.push_back(&row);
      else if (head == "function") function(row);
      else if (head == "atom-type") atom_type(row);
      else if (head == "connector-type") m_.connector_types.push_back(&row);
      else if (head == "atom") atom(row);
      else if (head == "choice") m_.choices.push_back(&row);
      else if (head == "connector") connectors.push_back(&row);
    }
    m_.first_port.push_back(m_.nodes.size());
    choice_node_.assign(m_.choices.size(), kNone);
    for (const Tree* row : connectors) connector(*row);
    for (std::size_t row = 0; row < m_.nodes.size(); ++row) {
      for (const Edge& edge : m_.nodes[row].children) m_.nodes[edge.node].parents.push_back(row);
    }
  }

 private:
  void port_type(const Tree& row) {
    m_.port_types.emplace_back();
    for (const Tree& item : row.items) {
      if (item.head() == "var") m_.port_types.back().push_back(item.items.at(2).text);
    }
  }
  void function(const Tree& row) {
    m_.functions.push_back(&row);
    if (row.find("ref") != nullptr) throw NotCheckable("C++ functions get references to variables");
  }

  void atom_type(const Tree& row) {
    AtomType type;
    type.name = row.items.at(2).text;
    for (const Tree& item : row.items) {
      const std::string& head = item.head();
      if (head == "slot") {
        type.slots.push_back(item.items.at(2).text);
        type.types.push_back(item.items.at(3).text);
        type.is_param.push_back(has_word(item, "param"));
      } else if (head == "port") {
        if (item.find("extern") != nullptr) throw NotCheckable("`" + type.name + "` waits for events from outside");
        type.exported.push_back(has_word(item, "export"));
        type.ports.push_back(item.items.at(2).text);
        type.port_slots.push_back(rows_of(item.find("slots")));
      } else if (head == "clock" || head == "resume") {
        // Bounds on clocks and resumptions would be taken for steps that are always there.
        throw NotCheckable("`" + type.name + "` depends on time");
      } else if (head == "place") {
        type.places.push_back(item.items.at(2).text);
      } else if (head == "invariant") {
        type.invariants.push_back(&item);
      } else if (head == "priority") {
        type.priorities.push_back(&item);
      } else if (head == "initial") {
        type.initial = rows_of(&item);
      } else if (head == "do") {
        type.initial_action = &item;
      } else if (head == "transition") {
        if (item.find("resume") != nullptr || has_word(item, "delayable") || has_word(item, "eager")) throw NotCheckable("`" + type.name + "` depends on time");
        const Tree* on = item.find("on");
        const Tree* guard = item.find("guard");
        type.transitions.push_back({on == nullptr ? kNone : on->items.at(1).row(), rows_of(item.find("from")), rows_of(item.find("to")),
                                    guard == nullptr ? nullptr : &guard->items.at(1), item.find("do")});
      } else if (head != "merged" && item.is_list) {
        throw NotCheckable("a row `" + head + "` of `" + type.name + "`");
      }
    }
    for (const Transition& t : type.transitions) {
      if (t.port != kNone && t.port >= type.ports.size()) throw Rejected("a transition of `" + type.name + "` has no such port");
    }
    type.written.resize(type.ports.size());
    type.is_automaton = type.initial.size() == 1 && std::all_of(type.transitions.begin(), type.transitions.end(),
                                                                [](const Transition& t) { return t.from.size() == 1 && t.to.size() == 1; });
    m_.atom_types.push_back(std::move(type));
  }

  void atom(const Tree& row) {
    Atom atom{row.items.at(2).text, row.items.at(3).row(), {}};
    if (const Tree* args = row.find("args")) {
      for (std::size_t k = 1; k < args->items.size(); ++k) atom.args.push_back(&args->items[k]);
    }
    m_.first_port.push_back(m_.nodes.size());
    for (const bool exported : m_.atom_types.at(atom.type).exported) {
      m_.nodes.emplace_back().is_step = !exported;
      m_.atom_of_port.push_back(m_.atoms.size());
    }
    m_.atoms.push_back(std::move(atom));
  }

  Edge binding(const Tree& b) {
    const std::string& head = b.head();
    const std::size_t row = b.items.at(1).row();
    if (head == "connector" || head == "maximal") return {m_.connectors.at(row).root, false, head == "maximal"};
    if (head == "atom") {
      const std::size_t port = m_.first_port.at(row) + b.items.at(2).row();
      if (port >= m_.first_port.at(row + 1)) throw Rejected("a binding to a port that there is not");
      return {port};
    }
    if (head != "choice") throw Rejected("a binding `" + head + "`");
    if (choice_node_.at(row) == kNone) {
      Node node;
      node.kind = Kind::Any;
      const Tree* ports = m_.choices[row]->find("ports");
      for (std::size_t k = 1; ports != nullptr && k < ports->items.size(); ++k) node.children.push_back(binding(ports->items[k]));
      m_.nodes.push_back(std::move(node));
      choice_node_[row] = m_.nodes.size() - 1;
    }
    return {choice_node_[row]};
  }

  // (synchron|trigger CHILD …) or (synchron|trigger PARAM)
  Edge group(const Tree& t, const Connector& c, int depth) {
    if (depth > 400) throw NotCheckable("groups are nested too deeply");
    if (!t.items.at(1).is_list) return c.params.at(t.items[1].row());
    Node node;
    node.kind = Kind::All;
    for (std::size_t k = 1; k < t.items.size(); ++k) {
      node.children.push_back(group(t.items[k], c, depth + 1));
      node.children.back().is_trigger = t.items[k].head() == "trigger";
      if (node.children.back().is_trigger) node.kind = Kind::Trigger;
    }
    m_.nodes.push_back(std::move(node));
    return {m_.nodes.size() - 1};
  }

  void connector(const Tree& row) {
    Connector c;
    c.type = m_.connector_types.at(row.items.at(3).row());
    c.data = row.find("data");
    c.path = row.items.at(2).text;
    if (const Tree* compound = row.find("in")) c.compound = compound->items.at(1).row();
    const Tree* ports = row.find("ports");
    const Tree* define = c.type->find("define");
    if (ports == nullptr || define == nullptr) throw Rejected("a connector without ports");
    for (std::size_t k = 1; k < ports->items.size(); ++k) c.params.push_back(binding(ports->items[k]));
    const Edge whole = group(define->items.at(1), c, 0);
    c.root = whole.node;
    if (!define->items[1].items.at(1).is_list) {
      c.root = m_.nodes.size();
      m_.nodes.emplace_back().kind = Kind::All;
      m_.nodes.back().children.push_back(whole);
    }
    m_.nodes[c.root].connector = m_.connectors.size();
    m_.nodes[c.root].is_step = c.type->find("export") == nullptr;
    written_by(c);
    m_.connectors.push_back(std::move(c));
  }

  // Transfers that write to the variables of ports.
  void written_by(const Connector& c) {
    std::vector<std::pair<std::size_t, std::size_t>> variables;  // param, variable
    std::size_t param = 0;
    for (const Tree& item : c.type->items) {
      if (item.head() != "param") continue;
      for (std::size_t v = 0; v < m_.port_types.at(item.items.at(3).row()).size(); ++v) variables.emplace_back(param, v);
      ++param;
    }
    if (param != c.params.size()) throw Rejected("a connector with another number of ports than its type");
    for (const Tree& clause : c.type->items) {
      if (clause.head() != "clause") continue;
      const Rows taking_part = rows_of(clause.find("params"));
      std::vector<const Tree*> todo{clause.find("up"), clause.find("down")};
      while (!todo.empty()) {
        const Tree* part = todo.back();
        todo.pop_back();
        for (std::size_t k = 0; part != nullptr && k < part->items.size(); ++k) {
          if (part->items[k].is_list) todo.push_back(&part->items[k]);
        }
        if (part == nullptr || part->head() != "set-bind") continue;
        const auto [which, variable] = variables.at(part->items.at(1).row());
        if (std::find(taking_part.begin(), taking_part.end(), which) == taking_part.end()) throw NotCheckable("a transfer writes to a port that does not take part");
        write(c.params[which].node, variable);
      }
    }
  }
  void write(std::size_t node, std::size_t variable) {
    if (m_.nodes[node].kind == Kind::Any) {
      for (const Edge& edge : m_.nodes[node].children) write(edge.node, variable);
    } else if (m_.nodes[node].kind == Kind::Port) {
      const std::size_t atom = m_.atom_of_port[node], port = node - m_.first_port[atom];
      AtomType& type = m_.atom_types[m_.atoms[atom].type];
      type.written[port].insert(type.port_slots.at(port).at(variable));
    }
  }

  Model& m_;
  Rows choice_node_;
};

}  // namespace

void read_model(std::string_view text, Model& model) {
  model.trees = read_trees(text);
  Reader(model).run();
}

}  // namespace certcheck
