// Patterns of lemmas: what a lemma says of the positions of arrays, so that it can be said of longer arrays.
//
// A cube over a small instance is a *word* for each dimension: letter k is what the cube demands of the elements with
// index k. Equal letters next to each other form a block. A block without demands, and one of two or more equal
// letters, repeats: in a longer word it has any length, 0 included. Other letters stand for themselves. So
// "machine[0] and [1] are white, [2] has the token, [4] of 5 is active" becomes "white*, token, any*, active": all
// positions of the token, and all active ones behind it. Patterns are guesses: Houdini decides which instances hold.
//
// The representation of sets of states by words over positions is that of regular model checking (A. Bouajjani, B.
// Jonsson, M. Nilsson, T. Touili: Regular Model Checking, 2000); here words are clauses, of one length at a time.
#pragma once
#include <set>

#include "compiler/verify/scaling/index_families.hpp"
#include "compiler/verify/symbolic/ic3.hpp"

namespace bip::verify {

/// A literal of a cube, of one element.
struct ElementLiteral {
  u32 family = 0;  // row of the largest instance's
  u32 index = 0;   // of a family that does not grow; else 0
  u32 is_place = 0, row = 0, position = 0, value = 0;
  friend auto operator<=>(const ElementLiteral&, const ElementLiteral&) = default;
};
using Letter = std::vector<ElementLiteral>;  // sorted
struct LetterBlock {
  Letter letter;
  bool repeats = false;
  friend auto operator<=>(const LetterBlock&, const LetterBlock&) = default;
};
struct LemmaPattern {
  Letter fixed;                                 // of families that do not grow
  std::vector<std::vector<LetterBlock>> words;  // by dimension; empty: it demands nothing there
  friend auto operator<=>(const LemmaPattern&, const LemmaPattern&) = default;
};

/// Adds the patterns of a cube. Two equal letters next to each other may be a block or two elements: both are added.
void add_patterns(const Cube& cube, const TransitionSystem& machine, const InstanceView& view,
                  const Dimensions& dimensions, std::set<LemmaPattern>& patterns);

/// Adds patterns that need no lemma: of two elements with a range of equal ones between them, of one with a range that
/// ends at it and a fixed component, of a range of all and two fixed components; places, and single bits of data at
/// places. False: they are more than `most`, and none was added.
bool add_templates(const TransitionSystem& machine, const InstanceView& view, const Dimensions& dimensions,
                   std::size_t most, std::set<LemmaPattern>& patterns);

/// Returns about how many literals the pattern's cubes have in an instance.
[[nodiscard]] double literal_estimate(const LemmaPattern& pattern, const InstanceView& view);

struct PatternInstance {
  Cube cube;
  std::vector<u32> patterns;  // rows of those that it is an instance of
};
struct InstanceLimits {
  std::size_t cubes = 300000, literals = 20000000;  // of all; patterns with fewer instances come first
};
/// Returns the cubes of the patterns in an instance, each once. Literals that it does not have leave an instance out.
[[nodiscard]] std::vector<PatternInstance> instantiate(const std::vector<LemmaPattern>& patterns,
                                                       const TransitionSystem& machine, const InstanceView& view,
                                                       const Dimensions& dimensions, const InstanceLimits& limits = {});

}  // namespace bip::verify
