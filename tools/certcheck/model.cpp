// From the rows of .bsys to the model. Trusts nothing: a row that points nowhere is rejected (`at` throws).
#include "tools/certcheck/model.hpp"

namespace certcheck {

namespace {

bool has_word(const Tree& list, std::string_view word) {
  for (const Tree& item : list.items) {
    if (!item.is_list && !item.is_string && item.text == word) return true;
  }
  return false;
}
std::vector<std::size_t> rows_of(const Tree* list) {
  std::vector<std::size_t> rows;
  for (std::size_t k = 1; list != nullptr && k < list->items.size(); ++k) rows.push_back(list->items[k].row());
  return rows;
}

class Reader {
 public:
  explicit Reader(Model& model) : m_(model) {}

  void run() {
    if (m_.trees.empty() || m_.trees[0].head() != "bsys" || m_.trees[0].items.at(1).text != "1") throw Rejected("not `(bsys 1)`");
    for (const Tree& row : m_.trees) {
      const std::string& head = row.head();
      if (head == "string") m_.strings.emplace(row.items.at(2).text, static_cast<std::int32_t>(row.items.at(1).row()));
      else if (head == "port-type") port_type(row);
      else if (head == "priority") m_.priorities.push_back(&row);
      else if (head == "function") function(row);
      else if (head == "atom-type") atom_type(row);
      else if (head == "connector-type") m_.connector_types.push_back(&row);
      else if (head == "atom") atom(row);
      else if (head == "choice") m_.choices.push_back(&row);
      else if (head == "connector") connectors_.push_back(&row);
    }
    m_.first_port.push_back(m_.nodes.size());
    choice_node_.assign(m_.choices.size(), kNone);
    for (const Tree* row : connectors_) connector(*row);
    for (std::size_t row = 0; row < m_.nodes.size(); ++row) {
      for (const auto& [child, trigger] : m_.nodes[row].children) m_.nodes[child].parents.push_back(row);
    }
  }

 private:
  static constexpr std::size_t kNone = ~std::size_t{0};
  static std::size_t count(const Tree& row, std::string_view head) {
    std::size_t n = 0;
    for (const Tree& item : row.items) n += item.head() == head ? 1 : 0;
    return n;
  }

  void port_type(const Tree& row) {
    m_.port_type_sizes.push_back(count(row, "var"));
    m_.port_type_types.emplace_back();
    for (const Tree& item : row.items) {
      if (item.head() == "var") m_.port_type_types.back().push_back(item.items.at(2).text);
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
      } else if (head == "initial") {
        type.initial = rows_of(&item);
      } else if (head == "do") {
        type.initial_action = &item;
      } else if (head == "transition") {
        Transition t;
        if (item.find("resume") != nullptr || has_word(item, "delayable") || has_word(item, "eager")) throw NotCheckable("`" + type.name + "` depends on time");
        if (const Tree* on = item.find("on")) {
          t.is_internal = false;
          t.port = on->items.at(1).row();
        }
        t.from = rows_of(item.find("from"));
        t.to = rows_of(item.find("to"));
        if (const Tree* guard = item.find("guard")) t.guard = &guard->items.at(1);
        t.action = item.find("do");
        type.transitions.push_back(t);
      } else if (head != "priority" && head != "merged" && item.is_list) {
        throw NotCheckable("a row `" + head + "` of `" + type.name + "`");
      }
    }
    type.written.resize(type.exported.size());
    type.maybe_hidden.assign(type.exported.size(), false);
    for (const Tree& item : row.items) {
      if (item.head() != "priority") continue;
      type.priorities.push_back(&item);
      const Tree* low = item.find("low");
      if (low == nullptr) throw Rejected("a priority without low side");
      for (std::size_t port = 0; port < type.exported.size(); ++port) {
        if (low->items.at(1).text == "any" || low->items.at(1).row() == port) type.maybe_hidden[port] = true;
      }
    }
    m_.atom_types.push_back(std::move(type));
  }

  void atom(const Tree& row) {
    Atom atom;
    atom.path = row.items.at(2).text;
    atom.type = row.items.at(3).row();
    if (const Tree* args = row.find("args")) {
      for (std::size_t k = 1; k < args->items.size(); ++k) atom.args.push_back(&args->items[k]);
    }
    m_.first_port.push_back(m_.nodes.size());
    for (const bool exported : m_.atom_types.at(atom.type).exported) {
      m_.nodes.push_back({});
      m_.nodes.back().is_step = !exported;
      m_.atom_of_port.push_back(m_.atoms.size());
    }
    m_.atoms.push_back(std::move(atom));
  }

  std::size_t binding(const Tree& b) {
    const std::string& head = b.head();
    if (head == "atom") return m_.first_port.at(b.items.at(1).row()) + b.items.at(2).row();
    if (head == "connector" || head == "maximal") return m_.connectors.at(b.items.at(1).row()).root;
    if (head != "choice") throw Rejected("a binding `" + head + "`");
    const std::size_t choice = b.items.at(1).row();
    if (choice_node_.at(choice) == kNone) {
      Node node;
      node.kind = Kind::Any;
      const Tree* ports = m_.choices[choice]->find("ports");
      for (std::size_t k = 1; ports != nullptr && k < ports->items.size(); ++k) node.children.emplace_back(binding(ports->items[k]), false);
      m_.nodes.push_back(std::move(node));
      choice_node_[choice] = m_.nodes.size() - 1;
    }
    return choice_node_[choice];
  }

  // (synchron|trigger CHILD …) or (synchron|trigger PARAM)
  std::size_t tree(const Tree& t, const Tree& ports, int depth) {
    if (depth > 2000) throw NotCheckable("groups are nested too deeply");
    if (!t.items.at(1).is_list) return binding(ports.items.at(1 + t.items[1].row()));
    Node node;
    node.kind = Kind::All;
    for (std::size_t k = 1; k < t.items.size(); ++k) {
      const bool trigger = t.items[k].head() == "trigger";
      if (trigger) node.kind = Kind::Trigger;
      node.children.emplace_back(tree(t.items[k], ports, depth + 1), trigger);
    }
    m_.nodes.push_back(std::move(node));
    return m_.nodes.size() - 1;
  }

  void connector(const Tree& row) {
    Connector c;
    c.type = row.items.at(3).row();
    c.ports = row.find("ports");
    c.data = row.find("data");
    c.path = row.items.at(2).text;
    if (const Tree* compound = row.find("in")) c.compound = compound->items.at(1).row();
    const Tree& type = *m_.connector_types.at(c.type);
    const Tree* define = type.find("define");
    if (c.ports == nullptr || define == nullptr) throw Rejected("a connector without ports");
    c.root = tree(define->items.at(1), *c.ports, 0);
    if (!define->items[1].items.at(1).is_list) {
      Node node;
      node.kind = Kind::All;
      node.children.emplace_back(c.root, false);
      m_.nodes.push_back(std::move(node));
      c.root = m_.nodes.size() - 1;
    }
    Node& root = m_.nodes[c.root];
    root.connector_type = &type;
    root.connector = m_.connectors.size();
    root.is_step = type.find("export") == nullptr;
    writes(type, *c.ports);
    m_.connectors.push_back(c);
  }

  void writes(const Tree& type, const Tree& ports) {
    std::vector<std::pair<std::size_t, std::size_t>> variables;  // param, variable
    std::size_t param = 0;
    for (const Tree& item : type.items) {
      if (item.head() != "param") continue;
      for (std::size_t v = 0; v < m_.port_type_sizes.at(item.items.at(3).row()); ++v) variables.emplace_back(param, v);
      ++param;
    }
    for (const Tree& clause : type.items) {
      if (clause.head() != "clause") continue;
      const std::vector<std::size_t> params = rows_of(clause.find("params"));
      const std::set<std::size_t> taking_part(params.begin(), params.end());
      for (const Tree* body : {clause.find("up"), clause.find("down")}) {
        std::vector<const Tree*> todo;
        if (body != nullptr) todo.push_back(body);
        while (!todo.empty()) {
          const Tree& part = *todo.back();
          todo.pop_back();
          for (const Tree& item : part.items) {
            if (item.is_list) todo.push_back(&item);
          }
          if (part.head() != "set-bind") continue;
          const auto [which, variable] = variables.at(part.items.at(1).row());
          if (!taking_part.contains(which)) throw NotCheckable("a transfer writes to a port that does not take part");
          write(ports.items.at(1 + which), variable);
        }
      }
    }
  }
  void write(const Tree& binding, std::size_t variable) {
    if (binding.head() == "atom") {
      AtomType& type = m_.atom_types[m_.atoms.at(binding.items.at(1).row()).type];
      const std::size_t port = binding.items.at(2).row();
      type.written.at(port).insert(type.port_slots.at(port).at(variable));
    } else if (binding.head() == "choice") {
      const Tree* ports = m_.choices.at(binding.items.at(1).row())->find("ports");
      for (std::size_t k = 1; ports != nullptr && k < ports->items.size(); ++k) write(ports->items[k], variable);
    }
  }

  Model& m_;
  std::vector<const Tree*> connectors_;
  std::vector<std::size_t> choice_node_;
};

}  // namespace

void read_model(std::string_view text, Model& model) {
  model.trees = read_trees(text);
  Reader(model).run();
}

}  // namespace certcheck
