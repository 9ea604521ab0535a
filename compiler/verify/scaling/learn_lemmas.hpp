// Learns lemmas from small instances of a model: IC3 proves the question for the smallest instance, the patterns of its
// lemmas are tried for the next size with Houdini, IC3 finds what is missing there, and so on, until the patterns alone
// prove the question for a size. Then they are worth trying for the instance in question.
//
// Of patterns that are enough, those are left out without which the rest still is: what a large instance has to check,
// and its certificate, become much smaller. In two orders: first those with the most instances in it (what is asked of
// one element needs no lemmas about all pairs), or first the most special ones (which may do for small sizes only).
//
// Where IC3's lemmas are about whole states, so that their patterns do not suffice at the next sizes, templates are
// tried beside them: pairs of elements with a range between them (invisible invariants proper).
//
// The lemmas are found without traps and place invariants, so that they are inductive by themselves: those of another
// size might not be found there. Reachable modes and affine invariants, which are found without candidates, help.
//
// After the invisible invariants of A. Pnueli, S. Ruah, L. Zuck (Automatic Deductive Verification with Invisible
// Invariants, 2001), with clauses of IC3 instead of projected sets of states, and ranges of positions instead of
// quantifiers over one or two.
#pragma once
#include <memory>
#include <set>

#include "compiler/verify/invariants/houdini.hpp"
#include "compiler/verify/scaling/lemma_patterns.hpp"
#include "compiler/verify/scaling/small_instance.hpp"

namespace bip::verify {

/// Grown: the patterns were not enough for this size, and now there are more. Enough: they were. Skipped: there is no
/// such instance. Failed: nothing is to be learnt, at this size or above.
enum class LearnStep : std::uint8_t { Grown, Enough, Skipped, Failed };

/// Two subsets that are enough. Cheapest: of patterns with few instances at the size in question.
/// Fewest: of general ones.
enum class PatternChoice : std::uint8_t { Cheapest, Fewest, All };

class LemmaLearner {
 public:
  /// Keeps references; the system is the instance in question. Nothing is learnt if its arrays have gaps.
  LemmaLearner(const System& system, const Question& question, const SmallInstances& instances, std::size_t megabytes);

  [[nodiscard]] LearnStep learn_at(std::uint32_t size, const CancellationToken& cancellation);
  /// Returns the patterns' cubes in the instance in question, whose circuit this is; none if another choice had the
  /// same. Requires that the last step was Enough.
  [[nodiscard]] std::vector<Cube> candidates(const TransitionSystem& machine, PatternChoice choice);
  [[nodiscard]] std::size_t pattern_count() const { return patterns_.size(); }

 private:
  /// The question at one size.
  struct SizedProblem {
    TransitionSystem machine;
    InstanceView view;
    Ic3Problem problem;
  };
  /// Grown: it was built.
  [[nodiscard]] LearnStep build_at(std::uint32_t size, const CancellationToken& cancellation, SizedProblem& sized);
  [[nodiscard]] InductiveLemmas filter_patterns(const Ic3Problem& problem, const InstanceView& view);
  void choose_size_above(std::uint32_t size, const CancellationToken& cancellation);
  [[nodiscard]] std::vector<LemmaPattern> needed(PatternChoice choice) const;

  const System& system_;
  const Question& question_;
  const SmallInstances& instances_;
  std::size_t megabytes_;
  std::optional<IndexFamilies> families_;
  std::optional<Dimensions> dimensions_;
  std::optional<InstanceView> large_view_;
  std::set<LemmaPattern> patterns_;
  std::unique_ptr<SizedProblem> enough_at_;  // of the last step that was Enough, or above it
  std::set<std::vector<LemmaPattern>> tried_;
  bool has_templates_ = false;
};

}  // namespace bip::verify
