// Properties of runs: linear temporal logic (Pnueli 1977) over conditions on states and over the steps of a run.
//
//   property = formula ('under' fairness)?          fairness.hpp
//   formula  = 'always' formula | 'never' formula | 'eventually' formula | 'next' formula
//            | formula ('leads to' | 'until' | 'unless' | 'implies') formula
//            | formula 'leads to' formula 'within' TIME | 'eventually' formula 'within' TIME
//            | 'previously' past | 'once' past | 'historically' past | past 'since' past
//            | C's `!`, `&&`, `||` over formulas | condition on a state (property.hpp)
//            | 'happens' CONNECTOR | 'happens' COMPONENT.PORT
//
// A run is an infinite sequence of stable states, each with the step that leaves it; after a deadlock or a final state
// the last state repeats for ever, and no step happens. `happens c` is true of a position if its step is an interaction
// of c. `until` is strong: its right side must come. `unless` is weak. A `past` formula has no word that looks ahead;
// before the first position nothing was true, so `previously E` is false there. Words before a formula reach as far as
// C's operators, which is what `never a && b` always meant; what could be read in two ways is an error.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compiler/base/result.hpp"
#include "compiler/verify/property/branching_formula.hpp"
#include "compiler/verify/property/fairness.hpp"
#include "compiler/verify/property/property.hpp"

namespace bip::verify {

/// Previously and Since look back: their operands have no Next, Until or Release.
enum class FormulaKind : std::uint8_t { Constant, State, Step, Not, And, Or, Next, Until, Release, Previously, Since };
struct FormulaNode {
  FormulaKind kind = FormulaKind::Constant;
  bool value = false;          // Constant
  std::uint32_t a = 0, b = 0;  // rows of nodes; Not, Next and Previously have no b
  std::uint32_t row = 0;       // State: of states; Step: of steps
};
/// A step is an interaction of the connector, or one in which the atom's port takes part.
struct StepCondition {
  bool is_port = false;
  std::uint32_t owner = 0;  // connector, or atom
  std::uint32_t port = 0;
  // Of a formula that a proof makes: one in which any of these instances of ports takes part, in ascending order. Those
  // of atoms that the proof does not follow may be left out.
  std::vector<std::uint32_t> instances = {};
};
struct Formula {
  std::vector<FormulaNode> nodes;  // operands before operators
  std::uint32_t root = 0;
  std::vector<Property> states;  // conditions, of type bool
  std::vector<StepCondition> steps;
  std::string text;
  // `E leads to F`, `eventually F`, `always eventually F` (then E is true): E and F as nodes without words of time.
  struct Response {
    bool asks_once = false;  // `eventually`: there is no E
    std::uint32_t request = 0, response = 0;
    std::optional<std::int64_t> within;  // ns; only of models with time
  };
  std::optional<Response> response;
  [[nodiscard]] bool has_limit() const { return response && response->within; }
};

/// A property of `--property`: of states, of runs, or, with the word `possibly`, of branching time.
enum class PropertyForm : std::uint8_t { State, Runs, Branching };
struct ParsedProperty {
  PropertyForm form = PropertyForm::State;
  Property state;                                   // State
  Formula formula;                                  // Runs
  BranchingFormula branching;                       // Branching
  std::optional<Fairness> fairness = std::nullopt;  // Runs, Branching: what is said behind `under`
};

/// Parses properties of any form and resolves their names in `system`, which must outlive it. The paths of the
/// system are listed once, so that each property costs what its text does.
class PropertyReader {
 public:
  explicit PropertyReader(const System& system);
  ~PropertyReader();
  PropertyReader(const PropertyReader&) = delete;
  PropertyReader& operator=(const PropertyReader&) = delete;
  /// Errors are those of parse_property. `always E` and `never E` of a condition E are properties of states.
  [[nodiscard]] Result<ParsedProperty> read(const std::string& text) const;

 private:
  const System& system_;
  std::unique_ptr<const struct RowsOfPaths> rows_;
};

[[nodiscard]] inline bool looks_back(FormulaKind kind) {
  return kind == FormulaKind::Previously || kind == FormulaKind::Since;
}
[[nodiscard]] inline bool looks_ahead(FormulaKind kind) {
  return kind == FormulaKind::Next || kind == FormulaKind::Until || kind == FormulaKind::Release;
}
/// Is it `always E` or `never E` where E looks back only? Then a finite run shows that it is violated.
[[nodiscard]] bool is_invariant_of_past(const Formula& formula);

/// Evaluates a node that looks back only at the last position of a finite run; as below.
[[nodiscard]] bool holds_at_last(const Formula& formula, std::uint32_t row, const std::vector<std::uint64_t>& states,
                                 const std::vector<std::uint64_t>& steps);
/// Evaluates a formula on a run that is a stem and a cycle: positions 0 … states.size() - 1, after the last one comes
/// `cycle`. `states`, `steps`: by position, bit k: condition k of the formula holds. Returns whether the run satisfies
/// it. Linear in nodes and positions; independent of automata.
[[nodiscard]] bool holds_on_lasso(const Formula& formula, const std::vector<std::uint64_t>& states,
                                  const std::vector<std::uint64_t>& steps, std::size_t cycle);

/// Returns the formula as certificates have it: "(release false (or (not (at ROOT.a P)) (until true (at ROOT.b Q))))";
/// nothing if that is too long, for parts that a formula shares are written wherever they are.
[[nodiscard]] std::optional<std::string> certificate_text(const Formula& formula, const System& system);

}  // namespace bip::verify
