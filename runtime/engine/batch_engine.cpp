// The batch engine: see batch_engine.hpp.
#include "runtime/engine/batch_engine.hpp"

#include <algorithm>
#include <thread>

#include "bip/assert.hpp"
#include "runtime/engine/interrupt.hpp"

namespace bip::rt {

namespace {

constexpr u64 kTestedEpoch = 8;  // small enough for runs of tests to have several

}  // namespace

BatchEngine::BatchEngine(Core& core, Scheduler& scheduler, const RunOptions& options, Output& output)
    : core_(core), scheduler_(scheduler), options_(options), output_(output) {
  if (!core.steps().can_batch() || !scheduler.is_uniform()) return;
  const u32 threads = options.threads != 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
  plan_ = plan_batch(core.tables(), core.priorities(), std::min<u32>(threads, kMostParts), options.perturb != 0);
  if (options.perturb != 0) {
    plan_.least_epoch = kTestedEpoch;
    plan_.perturb = options.perturb;
  }
  if (!is_on()) return;
  team_ = std::make_unique<Team>(plan_.parts);
  if (!output.writes_steps() || output.records_only()) return;
  follower_ = std::make_unique<Core>(core.image());
  BIP_ASSERT(plan_.part.size() == core.tables().interactions.size(), "{} interactions have parts", plan_.part.size());
  if (core.parts().has_draw_seed) follower_->seed_draws(core.parts().draw_seed);
  (void)follower_->initialize();
}

void BatchEngine::tell(const std::vector<InteractionId>& interactions) {
  if (!follower_) return output_.record(interactions);
  for (const InteractionId interaction : interactions) {
    const EnabledSet::Position at{interaction, 0};
    BIP_ASSERT(follower_->enabled().has(at), "interaction {} of step {} is no candidate", interaction, told_);
    output_.step(*follower_, at, told_++, follower_->enabled().number(at));
    (void)follower_->take(at);
  }
}

u64 BatchEngine::advance(u64 number, u64 limit, bool& sound) {
  BIP_ASSERT(is_on(), "the batch engine is off");
  told_ = number;
  std::function<void(const std::vector<InteractionId>&)> record;
  if (output_.writes_steps()) record = [this](const std::vector<InteractionId>& interactions) { tell(interactions); };
  const u64 done = core_.steps().run_batch(plan_, *team_, scheduler_.prng(), limit, is_interrupted, record);
  BIP_ASSERT(done <= limit, "{} steps of {}", done, limit);
  beside_ += done;
  // What is left of the limit, or what came to little beside each other; and the core's books are kept again.
  const u64 alone = core_.steps().run(
      scheduler_.prng(), std::min<u64>(limit - done, options_.perturb != 0 ? kTestedEpoch : Core::kHistory),
      is_interrupted, sound);
  if (record) tell(core_.history().recent(alone));
  BIP_ASSERT(done + alone <= limit, "{} steps and {} of {}", done, alone, limit);
  BIP_ASSERT(!follower_ || told_ == number + done + alone, "{} of {} steps were told", told_ - number, done + alone);
  return done + alone;
}

}  // namespace bip::rt
