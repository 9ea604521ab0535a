// Properties of branching time: computation tree logic (Clarke, Emerson 1981) over conditions on states. A property
// with the word `possibly` is one.
//
//   formula = 'possibly' path                 some run from this state
//           | path                            all runs from this state
//           | 'possibly' formula              some run reaches a state with it: short for `possibly eventually formula`
//           | C's `!`, `&&`, `||`, 'implies' over formulas | condition on a state
//   path    = 'always' formula | 'never' formula | 'eventually' formula | 'next' formula
//           | formula ('until' | 'unless') formula | formula 'leads to' formula (of all runs only)
//
// `possibly` before an operator with words that ask for all runs could speak of one run or of a state; that is an
// error. A state's runs are infinite: where no step leads anywhere, the state repeats.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/verify/property/property.hpp"
#include "compiler/system/system_ids.hpp"

namespace bip::verify {

enum class BranchingKind : std::uint8_t { Constant, State, NotState, And, Or, Next, Until, Release };
enum class Quantifier : std::uint8_t { All, Some };
struct BranchingNode {
  BranchingKind kind = BranchingKind::Constant;
  Quantifier quantifier = Quantifier::All;  // Next, Until, Release
  bool value = false;                       // Constant
  bool is_negation = false;                 // of what is written
  std::uint32_t a = 0, b = 0;               // rows of nodes; Next has no b
  std::uint32_t row = 0;                    // State, NotState: of states
  // Next, Until, Release: what is written, of a run: "reaches `E`", "has `always E`"; empty: a part of a word.
  std::string of_run = {};
};
/// In negation normal form: only conditions are negated, so that each node is a monotone function of its operands.
struct BranchingFormula {
  std::vector<BranchingNode> nodes;  // operands before operators
  std::uint32_t root = 0;
  std::vector<Property> states;  // conditions, of type bool, at most 64
  std::string text;
  // The property of all runs that this one negates: `never (E)` of `possibly E`, `eventually !(E)` of `possibly always
  // E`. Empty: it asks for no run, or for one with several words.
  std::string negation = {};
};

[[nodiscard]] inline bool is_quantified(BranchingKind kind) {
  return kind == BranchingKind::Next || kind == BranchingKind::Until || kind == BranchingKind::Release;
}
/// Does the property as a whole ask for some run?
[[nodiscard]] inline bool begins_with_possibly(const BranchingFormula& formula) {
  const BranchingNode& root = formula.nodes[formula.root];
  return is_quantified(root.kind) && root.quantifier == Quantifier::Some;
}

/// Returns the formula as certificates have it: "(all-release false (some-until true (at ROOT.a P)))"; nothing if that
/// is too long.
[[nodiscard]] std::optional<std::string> certificate_text(const BranchingFormula& formula, const System& system);

}  // namespace bip::verify
