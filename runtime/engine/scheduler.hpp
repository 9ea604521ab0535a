// Which candidate is taken: the three policies. `uniform` draws only if there is a choice; `fair` goes on after the slot that
// was fired last, cyclically. See semantics.md.
#pragma once
#include "bip/run.hpp"
#include "runtime/core/core.hpp"
#include "runtime/core/prng.hpp"

namespace bip::rt {

class Scheduler {
 public:
  Scheduler(Policy policy, std::uint64_t seed) : policy_(policy), prng_(seed) {}

  /// The number of the candidate to take. There must be one.
  std::uint64_t choose(const Core& core) {
    const std::uint64_t count = core.candidate_count();
    if (count <= 1) return 0;
    switch (policy_) {
      case Policy::Uniform: return prng_.below(count);
      case Policy::First: return 0;
      case Policy::Fair: return has_fired_ ? core.next_after(last_) : 0;
    }
    return 0;
  }
  void fired(u32 slot) {
    last_ = slot;
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
