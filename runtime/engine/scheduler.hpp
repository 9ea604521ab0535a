// Chooses the candidates of a run by a policy (policies.hpp), and owns the run's random numbers. See semantics.md.
#pragma once
#include <memory>

#include "bip/assert.hpp"
#include "bip/prng.hpp"
#include "bip/run.hpp"
#include "runtime/core/core.hpp"
#include "runtime/engine/policies.hpp"

namespace bip::rt {

class Scheduler {
 public:
  Scheduler(Policy policy, std::uint64_t seed)
      : prng_(seed), policy_(row_of(policy).is_uniform() ? nullptr : row_of(policy).make()) {}
  /// A copy goes on as the original does: the same numbers, the same memory.
  Scheduler(const Scheduler& other)
      : prng_(other.prng_), policy_(other.policy_ == nullptr ? nullptr : other.policy_->clone()) {}
  Scheduler& operator=(const Scheduler& other) {
    if (this != &other) *this = Scheduler(other);
    return *this;
  }
  Scheduler(Scheduler&&) noexcept = default;
  Scheduler& operator=(Scheduler&&) noexcept = default;
  ~Scheduler() = default;

  /// Once, after the initial state is known.
  void start(Core& core) const {
    if (is_uniform() && !core.weights().any()) core.keep_list();
  }
  /// Returns the candidate to take. Requires that there is one. `uniform` draws only if there is a choice.
  EnabledSet::Position choose(Core& core) {
    const std::uint64_t count = core.candidate_count();
    BIP_ASSERT(count != 0, "a choice without candidates");
    if (!is_uniform()) return policy_->choose(core, prng_);
    if (core.weights().any()) return count == 1 ? core.position(0) : core.weights().drawn(prng_.share());
    return core.enabled().drawn(count == 1 ? 0 : prng_.below(count));
  }
  /// The first candidate from the policy's on that may begin in this partial state. False: there is none.
  bool choose_decided(Core& core, EnabledSet::Position& at) {
    if (core.candidate_count() == 0) return false;
    at = choose(core);
    return find_decided(core, at);
  }
  /// The first candidate from `at` on that may begin in this partial state, in canonical order, cyclically. False:
  /// there is none.
  static bool find_decided(const Core& core, EnabledSet::Position& at);
  /// Returns a candidate of an interaction that has some.
  EnabledSet::Position choose_of(const Core& core, InteractionId interaction) {
    const u32 count = core.enabled().weight(interaction);
    BIP_ASSERT(count != 0, "interaction {} has no candidate", interaction);
    return {interaction, count == 1 || !is_uniform() ? 0 : static_cast<u32>(prng_.below(count))};
  }
  /// Every candidate is drawn with the same probability.
  [[nodiscard]] bool is_uniform() const { return policy_ == nullptr; }
  /// May a run take compiled steps? They draw by themselves, or choose by order.
  [[nodiscard]] bool knows_steps() const { return is_uniform() || policy_->order() != nullptr; }
  /// Takes compiled steps (CompiledSteps::run). Requires that the policy knows_steps.
  u64 run_steps(Core& core, u64 limit, bool (*is_stopped)(), bool& sound, Profile* profile = nullptr) {
    BIP_ASSERT(knows_steps(), "a policy that chooses step by step");
    if (is_uniform()) return core.steps().run(prng_, limit, is_stopped, sound, profile);
    core.keep_ordered_list();
    return core.steps().run(*policy_->order(), limit, is_stopped, sound, profile);
  }
  /// Returns the run's random numbers.
  [[nodiscard]] Prng& prng() { return prng_; }
  void fired(InteractionId interaction) {
    if (!is_uniform()) policy_->fired(interaction);
  }

 private:
  Prng prng_;
  std::unique_ptr<EnginePolicy> policy_;  // null: uniform
};

/// Returns a seed from the operating system, 32 bits so that it is easily typed again.
[[nodiscard]] std::uint64_t draw_seed();

}  // namespace bip::rt
