// Learns lemmas from small instances of a model: IC3 proves the question for the smallest instance, the patterns of its
// lemmas are tried for the next size with Houdini, IC3 finds what is missing there, and so on, until the patterns alone
// prove the question for a size. Then they are worth trying for the instance in question.
//
// Of patterns that are enough, those are left out, the most special ones first, without which the rest still is: what a
// large instance has to check, and its certificate, become much smaller.
//
// Where IC3's lemmas are about whole states, so that none of their patterns holds at the next size, templates are
// tried: pairs of elements with a range between them (invisible invariants proper).
//
// The lemmas are found without traps and place invariants, so that they are inductive by themselves: those of another
// size might not be found there. Reachable modes and affine invariants, which are found without candidates, help.
//
// After the invisible invariants of A. Pnueli, S. Ruah, L. Zuck (Automatic Deductive Verification with Invisible
// Invariants, 2001), with clauses of IC3 instead of projected sets of states, and ranges of positions instead of
// quantifiers over one or two.
#pragma once
#include <set>

#include "compiler/verify/invariants/houdini.hpp"
#include "compiler/verify/scaling/lemma_patterns.hpp"
#include "compiler/verify/scaling/small_instance.hpp"

namespace bip::verify {

/// Grown: the patterns were not enough for this size, and now there are more. Enough: they were. Skipped: there is no
/// such instance. Failed: nothing is to be learnt, at this size or above.
enum class LearnStep : std::uint8_t { Grown, Enough, Skipped, Failed };

enum class PatternChoice : std::uint8_t { Needed, All };

class LemmaLearner {
 public:
  /// Keeps references; the system is the instance in question. Nothing is learnt if its arrays have gaps.
  LemmaLearner(const System& system, const Question& question, const SmallInstances& instances, std::size_t megabytes);

  [[nodiscard]] LearnStep learn_at(std::uint32_t size, const CancellationToken& cancellation);
  /// Returns the patterns' cubes in the instance in question, whose circuit this is. Needed: of a subset of the
  /// patterns that the last size had enough of.
  [[nodiscard]] std::vector<Cube> candidates(const TransitionSystem& machine, PatternChoice choice) const;
  [[nodiscard]] std::size_t pattern_count() const { return patterns_.size(); }

 private:
  [[nodiscard]] InductiveLemmas filter_patterns(const Ic3Problem& problem, const InstanceView& view);
  void find_needed(const Ic3Problem& problem, const InstanceView& view);

  const System& system_;
  const Question& question_;
  const SmallInstances& instances_;
  std::size_t megabytes_;
  std::optional<IndexFamilies> families_;
  std::optional<Dimensions> dimensions_;
  std::optional<InstanceView> large_view_;
  std::set<LemmaPattern> patterns_;
  std::vector<LemmaPattern> needed_;
  bool has_templates_ = false;
};

}  // namespace bip::verify
