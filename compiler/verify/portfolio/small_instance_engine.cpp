// See small_instance_engine.hpp.
#include "compiler/verify/portfolio/small_instance_engine.hpp"

#include "compiler/verify/portfolio/induction_engines.hpp"
#include "compiler/verify/scaling/learn_lemmas.hpp"

namespace bip::verify {

namespace {

// Sizes to learn from. Below the first, words are too short to show what repeats.
constexpr std::uint32_t kFirstSize = 3, kLastSize = 8;

bool has_small_instances(const ProofContext& context) {
  return context.small_instances != nullptr && kIc3Engine.applies_to(context);
}

EngineResult prove_by_small_instances(ProofContext& context, const Budget& budget,
                                      const CancellationToken& cancellation) {
  EngineResult none;
  none.retry = Retry::Pointless;
  const CancellationToken share = cancellation.within(budget.seconds);
  LemmaLearner learner(context.parts.system(), context.question, *context.small_instances, context.limits.megabytes);
  for (std::uint32_t size = kFirstSize; size <= kLastSize && !share.is_over(); ++size) {
    context.report("small instances", learner.pattern_count(), "patterns");
    switch (learner.learn_at(size, share)) {
      case LearnStep::Skipped:
      case LearnStep::Grown: continue;
      case LearnStep::Failed: return none;
      case LearnStep::Enough: break;
    }
    for (const PatternChoice choice : {PatternChoice::Cheapest, PatternChoice::Fewest, PatternChoice::All}) {
      if (share.is_over()) break;
      EngineResult found =
          try_lemmas(context, {share.seconds_left()}, cancellation,
                     [&](const TransitionSystem& machine) { return learner.candidates(machine, choice); });
      if (found.outcome != Outcome::Unknown) return found;
    }
  }
  return none;
}

}  // namespace

const Engine kSmallInstanceEngine{"small instances", has_small_instances, prove_by_small_instances};

}  // namespace bip::verify
