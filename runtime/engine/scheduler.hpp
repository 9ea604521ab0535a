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
    if (is_uniform()) core.keep_list();
  }
  /// Returns the candidate to take. Requires that there is one. `uniform` draws only if there is a choice.
  EnabledSet::Position choose(const Core& core) {
    const std::uint64_t count = core.candidate_count();
    BIP_ASSERT(count != 0, "a choice without candidates");
    if (!is_uniform()) return policy_->choose(core, prng_);
    return core.enabled().drawn(count == 1 ? 0 : prng_.below(count));
  }
  /// Every candidate is drawn with the same probability: such a run may take compiled steps.
  [[nodiscard]] bool is_uniform() const { return policy_ == nullptr; }
  /// Returns the run's random numbers, for compiled steps, which draw by themselves.
  [[nodiscard]] Prng& prng() { return prng_; }
  void fired(u32 interaction) {
    if (!is_uniform()) policy_->fired(interaction);
  }

 private:
  Prng prng_;
  std::unique_ptr<EnginePolicy> policy_;  // null: uniform
};

/// Returns a seed from the operating system, 32 bits so that it is easily typed again.
[[nodiscard]] std::uint64_t draw_seed();

}  // namespace bip::rt
