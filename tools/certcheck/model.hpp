// What the checker needs of a system: atoms' types and all connectors as one graph over atoms' ports.
#pragma once
#include <cstdint>
#include <map>
#include <set>

#include "tools/certcheck/tree.hpp"

namespace certcheck {

inline constexpr std::size_t kNone = ~std::size_t{0};
using Rows = std::vector<std::size_t>;

struct Transition {
  std::size_t port = kNone;  // kNone: internal
  Rows from, to;
  const Tree* guard = nullptr;   // the expression
  const Tree* action = nullptr;  // (do …)
};
struct AtomType {
  std::string name;
  std::vector<std::string> slots, types, places, ports;
  std::vector<bool> is_param;
  std::vector<bool> exported;                       // by port
  std::vector<Rows> port_slots;
  std::vector<std::set<std::size_t>> written;       // by port: slots that a `down` may change
  Rows initial;
  const Tree* initial_action = nullptr;
  std::vector<Transition> transitions;
  std::vector<const Tree*> priorities, invariants;
  bool is_automaton = false;  // always exactly one place is marked
};
struct Atom {
  std::string path;
  std::size_t type = 0;
  std::vector<const Tree*> args;
};

/// All: a rendezvous. Trigger: a group with triggers. Any: exactly one of them (merged ports).
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
  const Tree* type = nullptr;
  const Tree* data = nullptr;
  std::vector<Edge> params;
  std::size_t root = 0, compound = 0;
  std::string path;
};

struct Model {
  std::vector<Tree> trees;
  std::map<std::string, int> strings;
  std::vector<std::vector<std::string>> port_types;  // the types of their variables
  std::vector<AtomType> atom_types;
  std::vector<const Tree*> connector_types, functions, priorities, choices;
  std::vector<Atom> atoms;
  Rows first_port;               // by atom, and the total: node of its port 0
  Rows atom_of_port;
  std::vector<Connector> connectors;
  std::vector<Node> nodes;       // children before parents; ports first

  [[nodiscard]] const AtomType& type_of(std::size_t atom) const { return atom_types[atoms[atom].type]; }
};

/// The trees must stay where they are: the model keeps pointers into them.
void read_model(std::string_view text, Model& model);

/// Types whose values are followed; of float and extern data nothing is known.
[[nodiscard]] inline bool is_exact(const std::string& type) { return type == "int" || type == "bool" || type == "string"; }

/// The rows after a list's head; none of a null list.
[[nodiscard]] Rows rows_of(const Tree* list);

}  // namespace certcheck
