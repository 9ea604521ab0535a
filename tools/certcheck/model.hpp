// What is read. Of a system: types of atoms, and all connectors as one graph over atoms' ports. Of a certificate: its rows, with names
// turned into numbers.
#pragma once
#include <map>
#include <optional>
#include <set>
#include <span>

#include <z3++.h>

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
/// A variable of a port that a connector binds: of which parameter, which one, its type.
using Bound = std::tuple<std::size_t, std::size_t, Text>;
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

inline constexpr int kMostWeight = 0x40000000;
/// By variable of an atom: its value, or nothing where it may be any.
using Values = std::vector<std::optional<int>>;
using Modes = std::set<std::size_t>;
struct Class {
  std::size_t type = 0;
  std::vector<bool> followed;  // by variable: places are
  std::vector<Values> modes;
  std::map<Values, std::size_t> numbers;
};
/// A variable is between two values, or one of its bits is set: or not. Of a set: the atom is in a mode.
struct Literal {
  std::size_t atom = 0, variable = 0;
  int low = 1, high = 1;
  std::optional<unsigned> bit = {};
  bool is_negated = false;
};
/// All literals hold; or, in a sum, a variable's value. Times its weight.
struct Case {
  std::vector<Literal> literals;
  bool is_value = false;
  int weight = 1;
};
/// One of the cases holds; or what they are, times their weights, adds up to the total, modulo 2^32.
struct Fact {
  std::string line;
  std::vector<Case> cases;
  std::optional<int> total;
};
struct Certificate {
  std::string claim;
  std::vector<Fact> facts, sets;  // sets: of modes; without total: traps
  std::set<std::vector<Values>> states;  // all that a search has reached: by atom, parameters as 0
  std::vector<Class> classes;  // none: the certificate says nothing of modes
  Rows class_of;               // by atom
  std::vector<Modes> reachable;
};

[[nodiscard]] Certificate read_certificate(const Model& model, const std::string& text);
/// Is it a proof? Says how much was checked; throws Rejected or NotCheckable (states.cpp). Z3 is slow to give up what it holds.
[[nodiscard]] std::string check(const Model& model, const std::string& certificate, z3::context& z);
/// Modes are closed, reachable ones and sets are kept by every step (structure.cpp).
void check_structure(const Model& model, const Certificate& certificate, z3::context& z);

}  // namespace certcheck
