// From the rows of .bsys to the model. Trusts nothing: a row that points nowhere is rejected (`at` throws).
#include "tools/certcheck/checked_model.hpp"

namespace certcheck {
namespace {

void only(const Tree& list, const std::vector<Text>& known, std::size_t first, Text owner) {
  for (std::size_t k = first; k < list.items.size(); ++k) {
    const Text word = list.items[k].is_list ? list.items[k].head() : list.items[k].text;
    if (!contains(known, word)) throw NotCheckable(quoted(owner) + " has " + quoted(word));
  }
}

class ModelReader {
 public:
  explicit ModelReader(Model& model) : model_(model) {}

  void run() {
    if (model_.tree.items.empty() || model_.tree.items[0].head() != "bsys" || model_.tree.items[0].at(1).text != "1")
      throw Rejected("not `(bsys 1)`");
    for (const Tree* row : model_.tree.all("string"))
      model_.strings.emplace(row->at(2).text, static_cast<int>(row->at(1).row()));
    model_.functions = model_.tree.all("function");
    for (const Tree* row : model_.functions)
      if (!(*row)["ref"].items.empty() && !row->has_word("draw", 3))
        throw NotCheckable("C++ functions get references to variables");
    for (const Tree* row : model_.tree.all("atom-type")) {
      try {
        atom_type(*row);
      } catch (const NotCheckable& e) {
        model_.atom_types.emplace_back().unfollowed = e.what();
      }
    }
    for (const Tree* row : model_.tree.all("atom")) atom(*row);
    model_.first_port.push_back(model_.nodes.size());
    for (const Tree* row : model_.tree.all("connector")) connector(*row, *connector_types_.at(row->at(3).row()));
    model_.priorities = model_.tree.all("priority");
    // Hidden below another connector: then an interaction that is offered need not be a step.
    for (const Tree* row : model_.priorities) {
      for (const Tree* side : {&(*row)["low"], &(*row)["high"]}) {
        for (std::size_t c : shown_) {
          const bool is_any = side->at(1).text == "any";
          if (is_any ? model_.connectors.at(c).compound == (*row)["in"].at(1).row() : side->at(1).row() == c)
            throw NotCheckable("a priority orders connectors that export a port");
        }
      }
    }
    for (std::size_t row = 0; row < model_.nodes.size(); ++row) {
      for (const Edge& edge : model_.nodes[row].children) model_.nodes[edge.node].parents.push_back(row);
    }
  }

 private:
  void atom_type(const Tree& row) {
    AtomType type;
    type.name = row.at(2).text;
    type.priorities = row.all("priority");
    type.invariants = row.all("invariant");
    only(row,
         {"slot", "port", "place", "initial", "do", "final", "transition", "priority", "invariant", "merged", "clock",
          "resume", "draws"},
         3, type.name);
    for (const Tree* place : row.all("place")) type.variables.push_back({place->at(2).text, "bool"});
    type.places = type.variables.size();
    for (const Tree* variable : row.all("slot"))
      type.variables.push_back({variable->at(2).text, variable->at(3).text, variable->has_word("param", 4)});
    const auto places = [&](const Tree& list) {
      const Rows rows = list.rows();
      const bool are_there = std::all_of(rows.begin(), rows.end(), [&](std::size_t p) { return p < type.places; });
      return are_there ? rows : throw Rejected(quoted(type.name) + " has no such place");
    };
    for (const Tree* port : row.all("port")) {
      if (!(*port)["extern"].items.empty()) throw NotCheckable(quoted(type.name) + " waits for events from outside");
      type.ports.push_back({port->at(2).text, port->has_word("export", 4), (*port)["slots"].rows(), {}});
      for (std::size_t& variable : type.ports.back().variables) variable += type.places;
    }
    for (const Tree* invariant : type.invariants) (void)places((*invariant)["places"]);
    type.initial = {kNone, {}, places(row["initial"]), nullptr, &row["do"], &row, &row["resume"]};
    type.finals = places(row["final"]);
    type.is_automaton = type.initial.to.size() == 1;
    for (const Tree* t : row.all("transition")) {
      only(*t, {"on", "from", "to", "guard", "bound", "measure", "delayable", "eager", "do", "resume", "weight"}, 2,
           type.name);
      const Rows on = (*t)["on"].rows();
      type.transitions.push_back({on.empty() ? kNone : on[0], places((*t)["from"]), places((*t)["to"]), &(*t)["guard"],
                                  &(*t)["do"], t, &(*t)["resume"], t->has_word("eager", 2),
                                  t->has_word("delayable", 2)});
      if (on.empty() && !t->find({"bound", "resume"}).empty()) throw Rejected("an internal transition waits");
      if (!on.empty() && on[0] >= type.ports.size()) throw Rejected(quoted(type.name) + " has no such port");
      type.is_automaton =
          type.is_automaton && type.transitions.back().from.size() == 1 && type.transitions.back().to.size() == 1;
    }
    for (const Tree* set : row.find({"set"})) {
      if (type.variables.at(type.places + set->at(1).row()).is_param)
        throw Rejected(quoted(type.name) + " writes to a parameter");
    }
    time(row, type);
    model_.atom_types.push_back(std::move(type));
  }

  void time(const Tree& row, AtomType& type) {
    type.first_clock = type.variables.size();
    for (const Tree* clock : row.all("clock")) {
      type.clocks.push_back({clock->at(2).text, clock->at(3).ticks(), type.places + clock->at(4).row()});
      if (type.clocks.back().unit <= 0 || type.clocks.back().first_slot + 2 >= type.first_clock)
        throw Rejected(quoted(type.name) + " has no such clock");
    }
    type.is_timed = !type.clocks.empty() || !type.initial.resume->items.empty() ||
                    std::any_of(type.transitions.begin(), type.transitions.end(), [](const Transition& t) {
                      return t.is_eager || t.is_delayable || !t.resume->items.empty();
                    });
    for (const Clock& clock : type.clocks) type.variables.push_back({clock.name, "clock"});
    type.waits = type.variables.size();
    // Names that no data have.
    if (type.is_timed) type.variables.insert(type.variables.end(), {{"resume", "int"}, {"resume-with", "int"}});
    for (const Tree* bound : row.find({"bound"})) {
      const Tree &minus = (*bound)["minus"], &slot = (*bound)["slot"];
      if (std::max(bound->at(2).row(), minus.items.empty() ? 0 : minus.at(1).row()) >= type.clocks.size() ||
          (!slot.items.empty() && type.places + slot.at(1).row() >= type.first_clock))
        throw Rejected(quoted(type.name) + " has no such bound");
    }
  }

  void atom(const Tree& row) {
    const AtomType& type = model_.atom_types.at(row.at(3).row());
    if (!type.unfollowed.empty()) throw NotCheckable(type.unfollowed);
    model_.first_port.push_back(model_.nodes.size());
    for (const Port& port : type.ports) {
      model_.nodes.emplace_back().is_step = !port.is_exported;
      model_.atom_of_port.push_back(model_.atoms.size());
    }
    model_.atoms.push_back({row.at(2).text, row.at(3).row(), &row["args"]});
    model_.is_timed = model_.is_timed || model_.type_of(model_.atoms.size() - 1).is_timed;
  }

  std::size_t add(Kind kind, std::vector<Edge> children) {
    if (children.empty()) throw Rejected("a group of nothing");
    model_.nodes.push_back({kind, std::move(children), {}});
    return model_.nodes.size() - 1;
  }

  Edge binding(const Tree& b) {
    const Text head = b.head();
    const std::size_t row = b.at(1).row();
    if (head == "maximal") shown_.insert(row);
    if (head == "connector" || head == "maximal") return {model_.connectors.at(row).root, false, head == "maximal"};
    if (head == "atom") {
      const std::size_t port = model_.first_port.at(row) + b.at(2).row();
      return port < model_.first_port.at(row + 1) ? Edge{port}
                                                  : throw Rejected("a binding to a port that there is not");
    }
    if (head != "choice") throw Rejected("a binding " + quoted(head));
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

  void connector(const Tree& row, const Tree& type) {
    Connector c{row.at(2).text, 0, row["in"].at(1).row(), {}, {}, &row["data"], {}, type["export"]["slots"].rows(), {}};
    c.is_sync = !type["resume"].items.empty();
    for (const Tree* variable : type.all("slot")) c.variables.push_back(variable->at(3).text);
    const std::vector<const Tree*> params = type.all("param");
    const Tree &ports = row["ports"], &define = type["define"].at(1);
    if (ports.items.size() != params.size() + 1)
      throw Rejected("a connector with another number of ports than its type");
    for (std::size_t p = 0; p < params.size(); ++p) {
      c.params.push_back(binding(ports.items[p + 1]));
      const std::vector<const Tree*> variables = port_types_.at(params[p]->at(3).row())->all("var");
      for (std::size_t v = 0; v < variables.size(); ++v) c.bound.push_back({p, v, variables[v]->at(2).text});
    }
    const Edge whole = group(define, c);
    c.root = define.at(1).is_list ? whole.node : add(Kind::All, {whole});
    model_.nodes[c.root].connector = model_.connectors.size();
    model_.nodes[c.root].is_step = type["export"].items.empty();
    for (const Tree* list : type.all("clause")) {
      const Clause& clause =
          c.clauses.emplace_back(Clause{(*list)["params"].rows(), &(*list)["guard"], &(*list)["up"], &(*list)["down"]});
      if (!clause.up->find({"set-bind"}).empty()) throw Rejected("an `up` writes to a port");
      for (const Tree* set : clause.down->find({"set-bind"})) {
        const auto& [param, variable, of_type] = c.bound.at(set->at(1).row());
        if (!contains(clause.params, param)) throw NotCheckable("a transfer writes to a port that does not take part");
        write(c.params[param].node, variable);
      }
    }
    model_.connectors.push_back(std::move(c));
  }
  // A transfer does, to a variable of a port or of what an inner connector exports, which passes it on by a transfer of
  // its own.
  void write(std::size_t row, std::size_t variable) {
    const Node& node = model_.nodes[row];
    for (const Edge& edge : node.connector == kNone ? node.children : std::vector<Edge>()) write(edge.node, variable);
    if (node.kind != Kind::Port) return;
    AtomType& type = model_.atom_types[model_.atoms[model_.atom_of_port[row]].type];
    Port& port = type.ports[row - model_.first_port[model_.atom_of_port[row]]];
    if (type.variables.at(port.variables.at(variable)).is_param) throw Rejected("a transfer writes to a parameter");
    port.written.insert(port.variables[variable]);
  }

  Model& model_;
  const std::vector<const Tree*> port_types_ = model_.tree.all("port-type"),
                                 connector_types_ = model_.tree.all("connector-type"),
                                 choices_ = model_.tree.all("choice");
  std::set<std::size_t> shown_;  // connectors whose ports compounds export
  Rows choice_node_ = Rows(choices_.size(), kNone);
};

}  // namespace

AtomType empty_type(Text name) {
  static const Tree kNothing{true, false, {}, {}};
  AtomType type;
  type.name = name;
  type.initial = {kNone, {}, {}, &kNothing, &kNothing, &kNothing, &kNothing};
  return type;
}

Model with_observer(const Model& model) {
  Model result = model;
  AtomType type = empty_type("observer");
  type.variables = {{"waits", "bool"}, {"to", "float"}, {"is-set", "bool"}, {"speed", "float"}, {"since", "clock"}};
  type.clocks = {{"since", 1, 1}};
  type.first_clock = 4;
  type.waits = 5;
  result.atoms.push_back({"observer", result.atom_types.size(), type.initial.row});
  result.atom_types.push_back(std::move(type));
  result.first_port.push_back(result.first_port.back());
  return result;
}

void read_model(std::string text, Model& model) {
  model.text = std::move(text);
  model.tree = read_trees(model.text);
  ModelReader(model).run();
}

}  // namespace certcheck
