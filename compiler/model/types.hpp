// The rows of the type model that instances share: port, connector and atom types with their code.
//
// Names are resolved, expressions are typed, all checks that need no instance are done. `model` builds them, `system`
// carries them unchanged, executors read them.
#pragma once
#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "compiler/model/code.hpp"
#include "compiler/model/time.hpp"

namespace bip {

using PortTypeId = Id<struct PortTypeTag>;
using AtomTypeId = Id<struct AtomTypeTag>;
using ConnectorTypeId = Id<struct ConnectorTypeTag>;

struct Variable {
  std::string name;
  Type type = Type::Int;
  Loc loc{};
  bool is_const = false;  // no transfer may change it; only the checks of `model` ask
};

struct PortType {
  std::string name;  // "?" + number for the anonymous ones of the paper's notation
  std::vector<Variable> variables;
  Loc loc{};
};

// ---- atoms ---------------------------------------------------------------------------------------------------
/// A variable of an atom: parameters first (read-only), then data in declaration order, then the hidden variables of
/// time and of random numbers.
struct DataVariable {
  std::string name;
  Type type = Type::Int;
  bool is_param = false;
  bool exported = false;
  Loc loc{};
};
struct Port {
  std::string name;
  PortTypeId type;
  std::vector<std::uint32_t> variables;  // one a variable of the port type
  bool exported = false;                 // false: its transitions are steps of their own
  Loc loc{};
  bool external = false;  // its transitions wait for an event from outside; not exported
  EventPolicy policy = EventPolicy::Remember;
  std::string event_class{};  // external: the C++ class of its events; may be empty
};
/// How likely a transition is beside others (`@weight(3)`, `@weight(rate)`): a number above 0, or a parameter's value.
struct Weight {
  static constexpr std::uint32_t kNone = 0xffffffffu;
  double value = 1;
  std::uint32_t param = kNone;  // row of the atom type's variables: a parameter, int or float

  [[nodiscard]] bool is_one() const { return param == kNone && value == 1; }
};
[[nodiscard]] inline bool is_weight(double value) { return value > 0 && value <= std::numeric_limits<double>::max(); }
struct Transition {
  static constexpr std::uint32_t kInternal = 0xffffffffu;
  std::uint32_t port = kInternal;   // row of ports
  std::vector<std::uint32_t> from;  // places, at least one
  std::vector<std::uint32_t> to;
  ExprId guard;   // invalid: true. Reads Self
  StmtId action;  // invalid: nothing. Reads and writes Self
  Loc loc{};
  TimeGuard when{};
  Urgency urgency = Urgency::Lazy;
  Resume resume{};
  Async async{};
  Weight weight{};
};
/// low < high provided guard: low is hidden while high is enabled (closed transitively through rules whose guards
/// hold).
struct AtomPriority {
  static constexpr std::uint32_t kAnyPort = 0xffffffffu;  // *: every port but the one on the other side
  std::string name;
  std::uint32_t low = 0, high = 0;  // rows of ports
  ExprId guard{};                   // invalid: true. Reads Self
  Loc loc{};
};
enum class InvariantScope : std::uint8_t { Always, At, From };
/// Holds after every firing: always, while the marking is exactly `places` (At), or while it includes them (From).
/// Time may not pass beyond the last instant at which `when` holds.
struct Invariant {
  std::string name;
  InvariantScope scope = InvariantScope::Always;
  std::vector<std::uint32_t> places;  // sorted
  ExprId condition{};                 // Reads Self; invalid: true, if there are bounds
  Loc loc{};
  TimeGuard when{};
};
/// `export port T p(x), q(y) as e`: e offers each enabled one of its ports as an alternative.
struct MergedPort {
  std::string name;
  PortTypeId type;
  std::vector<std::uint32_t> ports;  // rows of ports, at least two
  Loc loc{};
};
struct AtomType {
  std::string name;
  std::vector<DataVariable> variables;
  std::vector<Port> ports;
  std::vector<std::string> places;
  std::vector<std::uint32_t> initial;   // places
  StmtId initial_action;                // initialisers of data, then `initial … do`; Self
  std::vector<Transition> transitions;  // in source order
  std::vector<AtomPriority> priorities;
  std::vector<Invariant> invariants;
  std::vector<MergedPort> merged;  // their ports are exported under the merged name only
  Loc loc{};
  std::vector<Clock> clocks{};
  Resume initial_resume{};
  std::vector<std::uint32_t> final_places{};  // sorted; where the atom may be when a run has reached its end

  static constexpr std::uint32_t kNoDraws = 0xffffffffu;
  std::uint32_t draws = kNoDraws;  // the hidden variable that holds the generator: a float, read as bits

  /// Returns whether exactly one place is marked at any time: one initial place, one place on each side of each
  /// transition.
  [[nodiscard]] bool is_automaton() const {
    return initial.size() == 1 && std::all_of(transitions.begin(), transitions.end(), [](const Transition& t) {
             return t.from.size() == 1 && t.to.size() == 1;
           });
  }
  /// The first hidden variable: none of the model's own.
  [[nodiscard]] std::size_t visible_variables() const {
    const std::size_t before_clocks = clocks.empty() ? variables.size() : clocks.front().variable;
    return draws < before_clocks ? draws : before_clocks;
  }
};

// ---- connectors ----------------------------------------------------------------------------------------------
/// The `define` tree in preorder: node 0 is the root group. A leaf names a parameter.
struct DefineNode {
  bool is_leaf = false;
  bool trigger = false;
  std::uint32_t param = 0;              // leaf
  std::vector<std::uint32_t> children;  // group: rows of ConnectorType::define, all greater than this one
};
struct ConnectorParam {
  std::string name;  // for inline connectors the path, "a.p"
  PortTypeId type;
  std::uint32_t first_bind = 0;  // its variables are Bind first_bind … + variables of the port type
  Loc loc{};
};
/// Exported data of a participating component that the code reads (inline connectors).
struct DataRead {
  std::string path;  // "battery.totalPwr"
  Type type = Type::Int;
};
struct Clause {
  std::vector<std::uint32_t> params;  // sorted; an interaction that `define` gives
  ExprId guard;                       // invalid: true. Reads Bind and Self
  StmtId up;                          // writes Self only
  StmtId down;                        // writes Bind and Self
  Loc loc{};
};
struct ConnectorType {
  std::string name;
  std::vector<ConnectorParam> params{};
  std::vector<DataRead> data_reads{};     // Bind numbers after the port variables
  std::vector<DataVariable> variables{};  // its own data
  std::vector<DefineNode> define{};
  std::vector<Clause> clauses{};  // at most one an interaction
  bool exports = false;
  std::string export_name{};
  PortTypeId export_type{};
  std::vector<std::uint32_t> export_variables{};  // one a variable of export_type
  Loc loc{};
  ResumeMode resume = ResumeMode::Async;

  /// Number of Bind variables.
  [[nodiscard]] std::uint32_t bind_count(const IndexVector<PortTypeId, PortType>& types) const;
};

}  // namespace bip
