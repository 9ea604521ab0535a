// The image: a System as the runtime sees it. Constant tables plus native (or interpreted) code for guards, actions and
// transfers. The compiler fills it in memory for `run`; `build` and `emit` print the same tables as C++.
//
// Plain structs over spans, no ownership, no allocation: an emitted program keeps them in static storage.
// Every executor hands its image to the same core (core.hpp), which alone says what is enabled and what firing does.
//
// Emitted programs read this header and those that it includes: no <string>, no <vector>, no <algorithm>. image.hpp
// adds the texts that need them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <iosfwd>

#include "bip/contract.hpp"
#include "bip/id.hpp"
#include "bip/rows.hpp"
#include "bip/steps.hpp"

namespace bip::rt {

/// Rows [first, first + count) of a pool that the comment names.
struct Slice {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};

/// A native type, or from kFirstFfiType on a row of Image::ffi_types: the variable holds the address of a C++ object.
enum class CellType : std::uint16_t { Int, Bool, Float, String };
inline constexpr std::uint16_t kFirstFfiType = 4;
constexpr bool is_ffi(CellType type) { return static_cast<std::uint16_t>(type) >= kFirstFfiType; }
/// One variable. Bool is 0 or 1 in i; String is a row of Image::strings in i. Unused bits are zero.
union Cell {
  std::uint64_t bits;
  std::int32_t i;
  double f;
};
static_assert(sizeof(Cell) == 8);

/// Code over variables. `self`: variables of the atom or the connector's own data; `all`: all variables of the system;
/// `bind[k]`: row in `all` of the k-th bound variable (null for atoms). Never throws, never blocks.
/// Returns 0 = false (guards), 1 = true (guards) or done (actions), else a fault: see `fault_status`.
using CodeFn = std::int32_t (*)(const void* context, Cell* self, Cell* all, const std::uint32_t* bind);
struct Code {
  CodeFn fn = nullptr;
  const void* context = nullptr;
};

enum class FaultKind : std::uint8_t { DivisionByZero, DivisionOverflow };
/// The status of a fault at row `site` of Image::sites.
constexpr std::int32_t fault_status(std::uint32_t site, FaultKind kind) {
  return static_cast<std::int32_t>(2 + 2 * site + static_cast<std::uint32_t>(kind));
}

struct SourceLine {  // file: row of Image::files; line 0: none
  std::uint32_t file = 0, line = 0, column = 0;
};
/// A division or modulo in the source, a draw, or the call of a C++ function, whose fault is an exception.
struct Site {
  SourceLine loc;
  const char* function = nullptr;
  bool is_draw = false;  // a distribution of std.chance, not C++
};
/// What the runtime does with objects of a C++ type. Nothing throws.
struct FfiType {
  const char* name;
  void* (*make)();              // a new default one
  void (*reset)(void* object);  // to a default one
  void (*copy)(void* to, const void* from);
  bool (*equal)(const void*, const void*);  // null: its values cannot be compared
  void (*destroy)(void* object);
};
struct EventClass;  // image_time.hpp
class FfiContext;   // ffi.hpp

struct Var {
  const char* name;
  CellType type;
  bool is_param;
  bool exported;
};
struct PortType {
  const char* name;
  Span<Var> vars;
};
struct Port {
  const char* name;
  std::uint32_t type;
  Span<std::uint32_t> variables;  // one a variable of the port type
  bool exported;
  SourceLine loc;
};
struct Transition {
  std::uint32_t port;  // kNone: internal
  Span<std::uint32_t> from, to;
  std::uint32_t guard, action;  // rows of Image::codes or kNone
  SourceLine loc;
};
/// low is hidden while high is enabled and the guard holds, through chains of such rules.
struct AtomPriority {
  const char* name;
  std::uint32_t low, high;  // ports of the type; kNone: all but the one on the other side
  std::uint32_t guard;      // row of Image::codes or kNone
  SourceLine loc;
};
enum class InvariantScope : std::uint8_t { Always, At, From };
/// Holds after each firing: always, while the marking is exactly `places` (At), while it includes them (From).
struct Invariant {
  const char* name;
  InvariantScope scope;
  Span<std::uint32_t> places;
  std::uint32_t condition;  // row of Image::codes, or kNone if it bounds clocks only
  SourceLine loc;
};
struct AtomTime;  // image_time.hpp
struct AtomType {
  const char* name;
  Span<Var> variables;  // parameters first
  Span<Port> ports;
  Span<const char*> places;
  Span<std::uint32_t> initial;
  std::uint32_t initial_action;  // code or kNone; data variables are zero before it
  Span<Transition> transitions;
  SourceLine loc;
  Span<AtomPriority> priorities = {};
  Span<Invariant> invariants = {};
  const AtomTime* time = nullptr;         // null: it has nothing to do with time
  Span<std::uint32_t> final_places = {};  // where the atom may be when a run has reached its end
  std::uint32_t draws = kNone;            // the variable that holds the generator of its random numbers
  bool guards_call = false;  // guards, limits of clocks or invariants call C++: they may change without its data
};
/// Preorder; node 0 is the root group. children are rows of the same array.
struct DefineNode {
  bool is_leaf;
  bool trigger;
  std::uint32_t param;
  Span<std::uint32_t> children;
};
struct ConnectorParam {
  const char* name;
  std::uint32_t type;
  std::uint32_t first_bind;
};
/// A clause's code over ranges of values (runtime/core/search/ranges.hpp), in postfix form; operands have no effects.
enum class RangeOpKind : std::uint8_t {
  Constant,  // number
  Any,       // a value of which nothing is known
  Own,
  Bound,  // row: of the connector's variables, of its bound variables
  Neg,
  Add,
  Sub,
  Mul,
  Not,
  And,
  Or,
  Eq,
  Ne,
  Lt,
  Le,
  Store,  // row: of the connector's variables
  Branch  // the next `row` operations if so, the `otherwise` ones after them if not
};
struct RangeOp {
  RangeOpKind kind;
  CellType type;  // of the result; Store: of the variable
  std::uint32_t row = 0, otherwise = 0;
  double number = 0;
};
struct Clause {
  Span<std::uint32_t> params;  // sorted
  std::uint32_t guard, up, down;
  SourceLine loc;
  bool may_fault = false;  // its `up` can end in a fault: it runs while interactions are computed
  bool guard_may_fault = false;
  bool has_ranges = false;  // guard_ranges and up_ranges say what the code does; else it may fault
  Span<RangeOp> guard_ranges = {}, up_ranges = {};  // empty: no code
};
struct ConnectorType {
  const char* name;
  Span<ConnectorParam> params;
  Span<Var> variables;
  Span<DefineNode> define;
  Span<Clause> clauses;
  bool exports;
  const char* export_name;
  std::uint32_t export_type;
  Span<std::uint32_t> export_variables;
  SourceLine loc;
  bool resume_sync = false;  // the ports of an interaction resume together
  bool is_total = false;     // each interaction has a clause
};

struct Compound {
  const char* path;
  std::uint32_t parent;  // kNone for the root
};
struct Atom {
  const char* name;  // its path; with an index that stands where `#` is
  std::uint32_t type;
  std::uint32_t first_cell;  // row in `all` of its variable 0
  std::uint32_t args;        // first row of Image::args; one a parameter
  SourceLine loc;
  std::uint32_t index = kNone;
  [[nodiscard]] std::string path() const;  // "ROOT.phil[3]"; image.hpp
  [[nodiscard]] constexpr VariableId variable(std::uint32_t k) const { return VariableId(first_cell + k); }

  struct Slope {
    std::uint32_t first_cell, args;
  };
  [[nodiscard]] constexpr Atom after(const Slope& slope, std::uint32_t k) const {
    return {name, type, first_cell + k * slope.first_cell, args + k * slope.args, loc, index + k};
  }
};
struct PortRef {
  std::uint32_t atom;  // kNone: a connector's exported port
  std::uint32_t port;  // of the atom's type
  std::uint32_t connector;
  bool maximal_only;             // through a compound's exported port
  std::uint32_t choice = kNone;  // a merged port, row of Image::choices; atom, port and connector are kNone then

  struct Slope {
    std::uint32_t atom, connector, choice;
  };
  [[nodiscard]] constexpr PortRef after(const Slope& slope, std::uint32_t k) const {
    return {atom + k * slope.atom, port, connector + k * slope.connector, maximal_only, choice + k * slope.choice};
  }
};
/// A merged port: each enabled one of its ports is an alternative. No choice is among them.
struct Choice {
  const char* name;
  Span<PortRef> ports;
};
/// A parameter of a connector that is bound through a compound's exported port; `bip2` traces show that name.
struct ShownPort {
  std::uint32_t port_ref;  // row of Image::port_refs
  std::uint32_t compound;  // row of Image::compounds
  const char* name;        // of the exported port
};
struct Connector {
  const char* name;  // as an atom's
  std::uint32_t type;
  std::uint32_t first_cell;  // of its own data in `all`
  std::uint32_t ports;       // first row of Image::port_refs; one a parameter
  std::uint32_t binds;       // first row of Image::binds; bind_count rows
  std::uint32_t bind_count;
  bool bound;  // its exported port is bound by another connector
  SourceLine loc;
  std::uint32_t parent = 0;  // row of Image::compounds: the compound that declares it
  std::uint32_t index = kNone;
  [[nodiscard]] std::string path() const;
  [[nodiscard]] constexpr VariableId variable(std::uint32_t k) const { return VariableId(first_cell + k); }

  struct Slope {
    std::uint32_t first_cell, ports, binds, parent;
  };
  [[nodiscard]] constexpr Connector after(const Slope& slope, std::uint32_t k) const {
    return {name,
            type,
            first_cell + k * slope.first_cell,
            ports + k * slope.ports,
            binds + k * slope.binds,
            bind_count,
            bound,
            loc,
            parent + k * slope.parent,
            index + k};
  }
};
/// A bound variable: its row in `all`.
struct Bind {
  std::uint32_t cell;
  [[nodiscard]] constexpr VariableId variable() const { return VariableId(cell); }

  struct Slope {
    std::uint32_t cell;
  };
  [[nodiscard]] constexpr Bind after(const Slope& slope, std::uint32_t k) const { return {cell + k * slope.cell}; }
};
struct Pattern {
  bool any_connector;
  std::uint32_t connector;
  bool any_interaction;
  Span<std::uint32_t> params;  // sorted
};
struct Priority {
  const char* name;
  std::uint32_t parent;  // compound
  Pattern low, high;
  std::uint32_t guard;  // code or kNone
  std::uint32_t binds, bind_count;
  SourceLine loc;
};

/// How likely a transition is beside others: a number above 0, or the value of a parameter. Others have weight 1.
struct TransitionWeight {
  std::uint32_t type, transition;  // row of Image::atom_types, of its transitions
  double value;
  std::uint32_t param;  // row of the type's variables: a parameter; kNone: `value`
};
/// The same of the interactions of a connector.
struct ConnectorWeight {
  std::uint32_t connector;
  double value;
};

struct Image {
  const char* name = "";  // of the root type, "Ring(10)"
  Span<const char*> files;
  Span<const char*> strings;  // row 0 is always ""
  Span<Code> codes;
  Span<Site> sites;
  Span<PortType> port_types;
  Span<AtomType> atom_types;
  Span<ConnectorType> connector_types;
  Span<Compound> compounds;  // row 0: the root
  Rows<Atom> atoms;
  Span<Cell> args;
  Rows<Connector> connectors;  // a connector comes after those it is bound to
  Rows<PortRef> port_refs;
  Rows<Bind> binds;  // variables of a parameter bound to a choice: rows of its first alternative
  Span<Priority> priorities;
  std::uint32_t cell_count = 0;  // of all atoms, then of all connectors
  Span<Choice> choices = {};
  Span<ShownPort> shown_ports = {};  // by port_ref
  Span<FfiType> ffi_types = {};
  FfiContext* ffi = nullptr;  // if the model calls C++
  Span<EventClass> event_classes = {};
  Span<StepFn> step_fns = {};  // by shape; empty: no compiled steps
  Span<StepRun> step_runs = {};
  Span<StepOperand> step_operands = {};
  Span<StepEntry> step_entries = {};          // by shape
  StepsFn steps_fn = nullptr;                 // takes many steps; what it does step_fns do, too
  OrderedStepsFn ordered_steps_fn = nullptr;  // the same for policies that choose by order
  Span<StepColumn> step_columns = {};         // not empty: both work on cells, and know all interactions that can fire
  std::uint32_t step_cells = 0;               // how many
  std::uint32_t step_cells_pay = 0;           // after so many steps filling the columns has paid
  InnerSteps inner_steps = {};                // their shapes and operands are rows of step_fns and step_operands
  Span<TransitionWeight> transition_weights = {};  // in order; without these two all candidates are as likely
  Span<ConnectorWeight> connector_weights = {};    // in order
};

/// Returns whether the policy `uniform` draws some candidates more often than others.
constexpr bool is_weighted(const Image& image) {
  return image.transition_weights.size != 0 || image.connector_weights.size != 0;
}

/// Returns whether some atom draws random numbers.
inline bool has_draws(const Image& image) {
  for (const AtomType& type : image.atom_types) {
    if (type.draws != kNone) return true;
  }
  return false;
}

/// Requires is_ffi(type). Returns the row that describes the C++ type.
inline const FfiType& ffi_type(const Image& image, CellType type) {
  BIP_ASSERT(is_ffi(type), "type {} is a native one", type);
  return image.ffi_types[static_cast<std::uint32_t>(type) - kFirstFfiType];
}

}  // namespace bip::rt
