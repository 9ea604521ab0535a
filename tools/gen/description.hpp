// A random model as data: the generator creates it, the printer writes it as .bip, the shrinker reduces it and the
// naive oracle executes it. It is not the compiler's syntax tree on purpose: an error there must not be hidden here.
//
// Names are strings and references are names; models are small, so clarity matters more than speed.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace bip::gen {

/// Pair and Wide: the FFI types of random_ffi.hpp; Wide refines Pair.
enum class Ty : std::uint8_t { Int, Bool, Float, String, Pair, Wide };
[[nodiscard]] const char* name_of(Ty type);

/// Constant: `text` names it and args[0] is its value. Call: args of row `row` of ffi_functions(). Inline: `text`
/// names a function of the model and args follow; its last one is the function's body, whose parameters are names in
/// scope "$". Draw: from the distribution `text` of std.chance.
enum class ExprKind : std::uint8_t { Literal, Name, Unary, Binary, Constant, Call, Inline, Draw };
struct Expr {
  ExprKind kind = ExprKind::Literal;
  Ty type = Ty::Int;
  std::string text;         // Literal: as written; Unary, Binary: the operator
  std::string scope, name;  // Name: port, component or empty; the variable
  std::vector<Expr> args;
  int row = -1;               // Call
  bool extra_parens = false;  // printed in parentheses although none are needed
};

struct Stmt {
  bool is_if = false;
  bool is_call = false;     // `value` is a call, whose result is not wanted
  std::string scope, name;  // assignment's target
  Expr value;               // assigned value, or the condition
  std::vector<Stmt> then_body, else_body;
};
using Body = std::vector<Stmt>;

struct Var {
  std::string name;
  Ty type = Ty::Int;
  bool exported = false;
  std::optional<Expr> init;
};

struct PortType {
  std::string name;
  std::vector<Var> vars;
};

struct Port {
  std::string name, type;
  std::vector<std::string> vars;
  bool exported = true;
  std::string merged;  // not empty: exported under this name only, together with the others of it
  std::string event;   // not empty: for events from outside; remember, ignore, error
  /// What connectors call it.
  [[nodiscard]] const std::string& outer_name() const { return merged.empty() ? name : merged; }
};
/// A clock; `unit` as BIP2 names it.
struct Clock {
  std::string name, unit;
};
/// clock [- minus] op limit, in the clock's unit; the limit is a variable if it has a name.
struct ClockBound {
  std::string clock, minus, op, limit_name;
  int limit = 0;
};
struct ClockSet {
  std::string clock;
  int value = 0;
  bool is_speed = false;
};
struct AtomRule {
  std::string name, low, high;  // a port or "*"
  std::optional<Expr> guard;
};
struct Invariant {
  std::string name, scope;  // "", "at", "from"
  std::vector<std::string> places;
  Expr condition;
  std::vector<ClockBound> when;  // not empty: instead of the condition
};
struct Transition {
  std::string port;  // empty: internal
  std::vector<std::string> from, to;
  std::optional<Expr> guard;
  Body action;
  std::vector<ClockBound> when;
  std::string urgency;         // empty: lazy
  std::vector<ClockSet> sets;  // after the action
  bool resumes = false;
  std::vector<ClockBound> resume;
  bool is_async = false;
  int budget = 0;  // ms; 0: none
};
struct AtomType {
  std::string name;
  std::vector<Var> params, data;
  std::vector<Port> ports;
  std::vector<std::string> places, initial, finals;
  Body initial_action;
  std::vector<Transition> transitions;
  std::vector<AtomRule> rules;
  std::vector<Invariant> invariants;
  std::vector<Clock> clocks;
  bool paper = false;  // printed in the paper's notation
};

/// A leaf has a parameter, a group children.
struct Define {
  bool trigger = false;
  int param = -1;
  std::vector<Define> children;
};
struct Clause {
  std::vector<int> params;
  std::optional<Expr> guard;
  Body up, down;
};
struct ConnectorParam {
  std::string name, type;
};
struct ConnectorType {
  std::string name;
  std::vector<ConnectorParam> params;
  std::vector<Var> data;
  bool exports = false;
  std::string export_name, export_type;
  std::vector<std::string> export_vars;
  Define define;
  std::vector<Clause> clauses;
};

/// Element of an array: none, a constant, or (i + shift) % size inside a loop over 0..size.
struct Index {
  enum class Kind : std::uint8_t { None, Constant, Loop } kind = Kind::None;
  int value = 0;     // the constant or the shift
  std::string size;  // Loop: text of the array's size, a number or a parameter
};
struct PortPath {
  std::string component;  // or connector
  Index index;
  std::string port;
};
struct Component {
  std::string name, type;
  std::string size;  // empty: no array
  std::vector<Expr> args;
};
struct Connector {
  std::string name, type;
  std::string size;  // not empty: one for each i in 0..size
  std::vector<PortPath> ports;
};
struct Pattern {
  bool any_connector = false, any_interaction = false;
  std::string connector;
  std::vector<int> params;  // of the connector
};
struct Priority {
  std::string name;
  Pattern low, high;
  std::optional<Expr> guard;  // names: component . exported data
};
struct PortExport {
  std::vector<PortPath> targets;  // more than one: merged
  std::string name;
};
struct DataExport {
  std::string component, data, name;
  Ty type = Ty::Int;
};
struct CompoundType {
  std::string name;
  std::vector<Var> params;
  std::vector<Component> components;
  std::vector<Connector> connectors;
  std::vector<Priority> priorities;
  std::vector<PortExport> port_exports;
  std::vector<DataExport> data_exports;
  bool paper = false;  // printed in the paper's notation, its connectors inline
};

/// `function int f0(int n0) = …`: parameters are names in scope "$".
struct InlineFunction {
  std::string name;
  Ty result = Ty::Int;
  std::vector<Var> params;
  Expr body;
};

/// How a model is spread over packages: all in one; port types, constants and functions in `….base`; atom and connector
/// types in `….parts`, too.
enum class Split : std::uint8_t { One, Base, Parts };

struct Description {
  std::string package;
  Split split = Split::One;
  bool qualified = false;  // names of other packages are written with them
  bool draws = false;      // uses std.chance
  std::vector<Var> constants;
  std::vector<InlineFunction> functions;
  std::vector<PortType> port_types;
  std::vector<AtomType> atom_types;
  std::vector<ConnectorType> connector_types;
  std::vector<CompoundType> compound_types;  // the root is the last one
};

template <class T>
const T* find_named(const std::vector<T>& items, const std::string& name) {
  for (const T& item : items) {
    if (item.name == name) return &item;
  }
  return nullptr;
}

/// A random model of the seed. Timed: many of them have time, too. Drawn: as Timed, and some draw random numbers.
/// Plain: without merged ports, priorities of atoms and invariants.
enum class Features : std::uint8_t { All, Timed, Drawn, Plain };
[[nodiscard]] Description generate(std::uint64_t seed, Features features = Features::All);

/// Every interaction that `define` gives, as sorted sets of parameters, each once; by the definition in
/// language_meaning.md, section 4.
[[nodiscard]] std::vector<std::vector<int>> expand(const Define& define);

/// The model as .bip texts: packages in the order in which they are used, the root's last.
[[nodiscard]] std::vector<std::string> print_packages(const Description& model);
/// All of them as one text, for people.
[[nodiscard]] std::string print(const Description& model);

/// The receiver side of one broadcast as text, for tools/bench: a trigger and `receivers` synchrons.
[[nodiscard]] std::string broadcast_text(int receivers);

}  // namespace bip::gen
