// What the checker needs of a system: types of atoms, and all connectors as one graph over atoms' ports.
#pragma once
#include <map>
#include <set>
#include <span>

#include "tools/certcheck/tree.hpp"

namespace certcheck {

/// A place (a bool: is it marked?) or data.
struct Variable {
  Text name, type;
  bool is_param = false;
};
struct Port {
  Text name;
  bool is_exported = false;
  Rows variables;
  std::set<std::size_t> written;  // those that a `down` may change
};
struct Transition {
  std::size_t port = kNone;  // kNone: internal
  Rows from, to;
  const Tree *guard = nullptr, *action = nullptr;  // (guard …) and (do …), perhaps empty
};
struct AtomType {
  Text name;
  std::size_t places = 0;  // so many of the variables are places; data follows
  std::vector<Variable> variables;
  std::vector<Port> ports;
  Transition initial;  // from nowhere
  std::vector<Transition> transitions;
  std::vector<const Tree*> priorities, invariants;
  bool is_automaton = false;  // always exactly one place is marked

  /// The place or data of that name.
  [[nodiscard]] std::size_t find(Text variable, bool is_place) const {
    const std::span all(variables);
    return is_place ? row_of(all.first(places), variable, &Variable::name) : places + row_of(all.subspan(places), variable, &Variable::name);
  }
};
struct Atom {
  Text path;
  std::size_t type = 0;
  const Tree* args = nullptr;
};

struct Clause {
  Rows params;
  const Tree *guard = nullptr, *up = nullptr, *down = nullptr;
};
/// All: a rendezvous. Trigger: a group with triggers. Any: exactly one of them (merged ports), each of which is a rendezvous of one.
enum class Kind { Port, All, Trigger, Any };
struct Edge {
  std::size_t node = 0;
  bool is_trigger = false;
  bool is_maximal = false;  // only the largest interactions of the connector there
};
struct Node {
  Kind kind = Kind::Port;
  std::vector<Edge> children;
  Rows parents;
  bool is_step = false;
  std::size_t connector = kNone;  // whose root group it is
};
/// A variable of a port that a connector binds.
struct Bound {
  std::size_t param = 0, variable = 0;
  Text type;
};
struct Connector {
  Text path;
  std::size_t root = 0, compound = 0;
  std::vector<Edge> params;
  std::vector<Bound> bound;
  const Tree* data = nullptr;
  std::vector<Text> slots;  // their types
  Rows exported;            // slots of the port that it exports
  std::vector<Clause> clauses;
};

struct Model {
  std::string text;
  Tree tree;
  std::map<Text, int> strings;
  std::vector<AtomType> atom_types;
  std::vector<const Tree*> functions, priorities;
  std::vector<Atom> atoms;
  Rows first_port;  // by atom, and the total: node of its port 0
  Rows atom_of_port;
  std::vector<Connector> connectors;
  std::vector<Node> nodes;  // children before parents; ports first

  [[nodiscard]] const AtomType& type_of(std::size_t atom) const { return atom_types[atoms[atom].type]; }
  [[nodiscard]] const Port& port(std::size_t node) const { return type_of(atom_of_port.at(node)).ports[node - first_port[atom_of_port[node]]]; }
};

/// The model keeps the text, and points into it.
void read_model(std::string text, Model& model);

/// Types whose values are followed; of float and extern data nothing is known.
[[nodiscard]] inline bool is_exact(Text type) { return type == "int" || type == "bool" || type == "string"; }

}  // namespace certcheck
