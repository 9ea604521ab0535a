// Which candidate is taken: the three policies. `uniform` draws only if there is a choice; `fair` goes on after the
// interaction that was fired last, cyclically. See semantics.md.
#pragma once
#include "bip/run.hpp"
#include "runtime/core/core.hpp"
#include "bip/prng.hpp"

namespace bip::rt {

class Scheduler {
 public:
  Scheduler(Policy policy, std::uint64_t seed) : policy_(policy), prng_(seed) {}

  /// Once, after the initial state is known.
  void start(Core& core) const {
    if (policy_ == Policy::Uniform) core.keep_list();
  }
  /// The candidate to take. There must be one.
  EnabledSet::Position choose(const Core& core) {
    const std::uint64_t count = core.candidate_count();
    switch (policy_) {
      case Policy::Uniform: return core.drawn(count == 1 ? 0 : prng_.below(count));
      case Policy::First: break;
      case Policy::Fair: return core.position(has_fired_ && count > 1 ? core.next_after(last_) : 0);
    }
    return core.position(0);
  }
  /// The random numbers of `uniform`, for who draws by himself.
  [[nodiscard]] Prng& prng() { return prng_; }
  void fired(u32 interaction) {
    last_ = interaction;
    has_fired_ = true;
  }

 private:
  Policy policy_;
  Prng prng_;
  u32 last_ = 0;
  bool has_fired_ = false;
};

/// A seed from the operating system, 32 bits so that it is easily typed again.
[[nodiscard]] std::uint64_t draw_seed();

}  // namespace bip::rt
