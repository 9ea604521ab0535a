// What the checker needs of a system: types of atoms, and all connectors as one graph over atoms' ports.
#pragma once
#include <map>
#include <set>

#include "tools/certcheck/tree.hpp"

namespace certcheck {

struct Transition {
  std::size_t port = kNone;  // kNone: internal
  Rows from, to;
  const Tree* guard = nullptr;   // (guard …) and (do …), perhaps empty
  const Tree* action = nullptr;
};
struct AtomType {
  std::string_view name;
  std::vector<std::string_view> slots, types, places, ports;
  std::vector<bool> is_param, is_exported;     // by slot, by port
  std::vector<Rows> port_slots;
  std::vector<std::set<std::size_t>> written;  // by port: slots that a `down` may change
  Rows initial;
  const Tree* initial_action = nullptr;
  std::vector<Transition> transitions;
  std::vector<const Tree*> priorities, invariants;
  bool is_automaton = false;  // always exactly one place is marked
};
struct Atom {
  std::string_view path;
  std::size_t type = 0;
  const Tree* args = nullptr;
};

struct Clause {
  Rows params;
  const Tree *guard = nullptr, *up = nullptr, *down = nullptr;
};
struct ConnectorType {
  Rows params;                          // their port types
  std::vector<std::string_view> slots;  // their types
  std::vector<Clause> clauses;
  Rows exported;                        // slots of the port that it exports
  bool is_exported = false;
  const Tree* define = nullptr;         // its group
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
struct Connector {
  std::string_view path;
  std::size_t type = 0, root = 0, compound = 0;
  std::vector<Edge> params;
  const Tree* data = nullptr;
};

struct Model {
  std::string text;
  Tree tree;
  std::map<std::string_view, int> strings;
  std::vector<std::vector<std::string_view>> port_types;  // the types of their variables
  std::vector<AtomType> atom_types;
  std::vector<ConnectorType> connector_types;
  std::vector<const Tree*> functions, priorities;
  std::vector<Atom> atoms;
  Rows first_port;               // by atom, and the total: node of its port 0
  Rows atom_of_port;
  std::vector<Connector> connectors;
  std::vector<Node> nodes;       // children before parents; ports first

  [[nodiscard]] const AtomType& type_of(std::size_t atom) const { return atom_types[atoms[atom].type]; }
};

/// The model keeps the text, and points into it.
void read_model(std::string text, Model& model);

/// Types whose values are followed; of float and extern data nothing is known.
[[nodiscard]] inline bool is_exact(std::string_view type) { return type == "int" || type == "bool" || type == "string"; }

}  // namespace certcheck
