// See step_follower.hpp.
#include "runtime/engine/step_follower.hpp"

#include "bip/assert.hpp"

namespace bip::rt {

bool can_follow_steps(const Core& core, const Output& output) {
  return output.writes_steps() && !output.records_only() && core.image().ffi == nullptr && !core.is_timed();
}

StepFollower::StepFollower(const Core& core, const State& initial) : core_(core.image(), core.parts().options) {
  BIP_ENSURE(core_.initialize() && core_.restore(initial), "the initial state has no fault");
}

bool StepFollower::take(EnabledSet::Position at, u64 number, Output& output, StepText& text) {
  text.out.clear();
  text.trace.clear();
  if (has_met_fault_ || !core_.enabled().has(at)) return false;
  output.describe(text, core_, at, number, kNoChoice);
  // The step with a fault is written, and is the last one.
  has_met_fault_ = !core_.take(at);
  return true;
}

}  // namespace bip::rt
