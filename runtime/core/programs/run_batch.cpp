// Epochs of compiled steps on several threads: see batch_engine.hpp. An epoch costs two meetings of the threads and one
// pass over the list of the enabled, which is cut into the parts' lists before and joined after; so it is as long as
// the system is large.
#include <algorithm>
#include <chrono>
#include <thread>

#include "runtime/core/programs/batch.hpp"
#include "runtime/core/core.hpp"
#include "runtime/core/programs/team.hpp"

namespace bip::rt {

namespace {

constexpr u64 kMostEpoch = 1u << 22;
constexpr u32 kTriesPerStep = 16;  // draws among the shared interactions until one is enabled

void wait_a_little(u64 seed) {
  const u64 how = Prng(seed).below(8);
  if (how == 0) std::this_thread::sleep_for(std::chrono::microseconds(20));
  else if (how < 4) std::this_thread::yield();
}

}  // namespace

bool Core::can_batch() const {
  if (!has_steps()) return false;
  for (u32 interaction = 0; interaction < tables_.interactions.size(); ++interaction) {
    if (run_of_[interaction] == kNone) return false;
  }
  return true;
}

// The part's share: whom it draws among the shared ones is left to the end of the epoch.
void Core::run_part(const BatchPlan& plan, BatchPart& part, bool records) {
  StepState s{all_.data(),         places_.data(), values_.data(), part.members.data(), enabled_.open_list().position,
              part.scratch.data(), part.count};
  const std::uint8_t* const is_shared = plan.is_shared.data();
  Prng numbers = part.prng;
  u64 steps = 0;
  for (u64 draw = 0; draw < part.draws && s.count != 0; ++draw) {
    const u32 interaction = s.members[numbers.below(s.count)];
    if (is_shared[interaction] != 0) continue;
    const CompiledRun& run = runs_[run_of_[interaction]];
    run.fn(s, run.operands, static_cast<u32>((interaction - run.first) * run.inverse >> 32));
    if (records) part.fired.push_back(interaction);
    ++steps;
  }
  part.prng = numbers;
  part.count = s.count;
  part.steps = steps;
}

void Core::cut_list(const BatchPlan& plan, std::vector<BatchPart>& parts, u64 draws) {
  const EnabledSet::List list = enabled_.open_list();
  for (BatchPart& part : parts) part.count = 0;
  for (u32 i = 0; i < *list.count; ++i) {
    const u32 interaction = list.members[i];
    BatchPart& part = parts[plan.part[interaction]];
    list.position[interaction] = part.count;
    part.members[part.count++] = interaction;
  }
  for (BatchPart& part : parts) {
    part.draws = draws * part.count / *list.count;
    part.fired.clear();
  }
}

void Core::join_list(const std::vector<BatchPart>& parts) {
  const EnabledSet::List list = enabled_.open_list();
  u32 count = 0;
  for (const BatchPart& part : parts) {
    for (u32 i = 0; i < part.count; ++i) {
      const u32 interaction = part.members[i];
      list.position[interaction] = count;
      list.members[count++] = interaction;
    }
  }
  enabled_.close_list(count);
}

// Up to `draws` steps among the shared interactions.
u64 Core::run_shared(const BatchPlan& plan, Prng& prng, u64 draws, std::vector<u32>& fired) {
  const EnabledSet::List list = enabled_.open_list();
  StepState s{all_.data(),   places_.data(),       values_.data(), list.members,
              list.position, step_scratch_.data(), *list.count};
  u64 steps = 0;
  for (u64 tries = draws * kTriesPerStep; steps < draws && tries > 0 && !plan.shared.empty(); --tries) {
    const u32 interaction = plan.shared[prng.below(plan.shared.size())];
    if (s.position[interaction] == kAbsentInteraction) continue;
    const CompiledRun& run = runs_[run_of_[interaction]];
    run.fn(s, run.operands, static_cast<u32>((interaction - run.first) * run.inverse >> 32));
    fired.push_back(interaction);
    ++steps;
  }
  enabled_.close_list(s.count);
  return steps;
}

u64 Core::run_batch(const BatchPlan& plan, Team& team, Prng& prng, u64 limit, bool (*is_stopped)(),
                    const std::function<void(const std::vector<u32>&)>& record) {
  const u64 epoch = std::min(std::max<u64>(tables_.interactions.size() * 2, plan.least_epoch), kMostEpoch);
  std::vector<BatchPart> parts(plan.parts);
  for (u32 k = 0; k < plan.parts; ++k) {
    parts[k].prng = Prng(prng.next());
    parts[k].members.assign(std::size_t{plan.size[k]} + 1, 0);
    parts[k].scratch = step_scratch_;
  }
  std::vector<u32> fired;
  u64 done = 0;
  while (enabled_.listed_count() != 0 && limit - done >= plan.least_epoch && !is_stopped()) {
    const u64 draws = std::min(epoch, limit - done);
    cut_list(plan, parts, draws);
    team.run([&](u32 k) {
      if (k >= plan.parts) return;
      if (plan.perturb != 0) wait_a_little(plan.perturb + done * kMostParts + k);
      run_part(plan, parts[k], record != nullptr);
    });
    join_list(parts);
    u64 steps = 0, left = draws;
    for (const BatchPart& part : parts) {
      steps += part.steps;
      left -= std::min(left, part.draws);
      left += part.draws - part.steps;
      if (record) record(part.fired);
    }
    fired.clear();
    steps += run_shared(plan, prng, std::min(left, draws - steps), fired);
    if (record) record(fired);
    done += steps;
    // Too little to do beside each other: the short way takes over.
    if (steps * 2 < draws) break;
  }
  // The ring of interactions fired last knows nothing of these.
  if (done != 0) std::fill(history_.begin(), history_.end(), kNone);
  return done;
}

}  // namespace bip::rt
