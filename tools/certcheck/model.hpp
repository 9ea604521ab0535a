// What the checker needs of a system: atoms' local behaviour and connectors as one graph.
#pragma once
#include <compare>
#include <cstdint>
#include <map>
#include <set>

#include "tools/certcheck/tree.hpp"

namespace certcheck {

/// A value, or anything.
struct Value {
  bool is_known = false;
  std::int32_t value = 0;
  friend auto operator<=>(const Value&, const Value&) = default;
};

struct Transition {
  bool is_internal = true;
  std::size_t port = 0;
  std::vector<std::size_t> from, to;
  const Tree* guard = nullptr;   // the expression
  const Tree* action = nullptr;  // (do …)
};
struct AtomType {
  std::string name;
  std::vector<std::string> slots, types, places;
  std::vector<bool> is_param;
  std::vector<bool> exported;                       // by port
  std::vector<std::vector<std::size_t>> port_slots;
  std::vector<std::set<std::size_t>> written;       // by port: slots that a `down` may change
  std::vector<bool> maybe_hidden;                   // by port: low in a priority of the atom
  std::vector<std::size_t> initial;
  const Tree* initial_action = nullptr;
  std::vector<Transition> transitions;
  std::vector<std::string> ports;
  std::vector<const Tree*> priorities, invariants;
};
struct Atom {
  std::string path;
  std::size_t type = 0;
  std::vector<const Tree*> args;
};
struct LocalState {
  std::set<std::size_t> places;
  std::vector<Value> values;
  friend auto operator<=>(const LocalState&, const LocalState&) = default;
};

enum class Kind { Port, All, Trigger, Any };
struct Node {
  Kind kind = Kind::Port;
  std::vector<std::pair<std::size_t, bool>> children;  // is it a trigger?
  std::vector<std::size_t> parents;
  bool is_step = false;
  const Tree* connector_type = nullptr;  // the root group of a connector
  std::size_t connector = 0;
};
struct Connector {
  std::size_t type = 0;
  const Tree* ports = nullptr;
  const Tree* data = nullptr;
  std::size_t root = 0;
  std::string path;
  std::size_t compound = 0;
};

struct Model {
  std::vector<Tree> trees;
  std::map<std::string, std::int32_t> strings;
  std::vector<std::size_t> port_type_sizes;
  std::vector<std::vector<std::string>> port_type_types;
  std::vector<AtomType> atom_types;
  std::vector<const Tree*> connector_types, functions, priorities;
  std::vector<Atom> atoms;
  std::vector<std::size_t> first_port;   // by atom, and the total: node of its port 0
  std::vector<std::size_t> atom_of_port;
  std::vector<const Tree*> choices;
  std::vector<Connector> connectors;
  std::vector<Node> nodes;               // children before parents

  [[nodiscard]] Value evaluate(const Tree& expr, const std::vector<Value>& self, const std::vector<Value>& bind) const;
  void execute(const Tree* body, std::size_t first, std::vector<Value>& self) const;
  /// Stable states after internal transitions, data outside of `followed` forgotten.
  [[nodiscard]] std::set<LocalState> settle(const AtomType& type, const LocalState& start, const std::vector<bool>& followed) const;
  [[nodiscard]] std::set<LocalState> initial_states(const Atom& atom, const std::vector<bool>& followed) const;
  [[nodiscard]] std::set<LocalState> after(const AtomType& type, const LocalState& state, std::size_t port, const std::vector<bool>& followed) const;
  /// Is a transition of the port enabled whatever is not known?
  [[nodiscard]] bool is_sure(const AtomType& type, const LocalState& state, std::size_t port) const;
};

/// The trees must stay where they are: the model keeps pointers into them.
void read_model(std::string_view text, Model& model);

}  // namespace certcheck
