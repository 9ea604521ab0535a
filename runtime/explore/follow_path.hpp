// Takes a path from the initial state in a core: what all texts about a counterexample have in common.
#pragma once
#include "bip/draws.hpp"
#include "runtime/core/core.hpp"
#include "runtime/explore/counterexample.hpp"
#include "runtime/explore/zones.hpp"

namespace bip::rt {

/// Initializes the core of a search: no component may draw one of several values then. False: a fault.
inline bool begins(Core& core) {
  DrawScript script = DrawScript::without_choices();
  const FollowedScript follow(script);
  return core.initialize();
}

/// Initializes the core and takes the path's steps; before(number, choice) is called before each of them, foresee()
/// before time passes to it. Stops at a fault, or at a step that is not possible. Then time passes to the path's end.
/// Returns how many steps were taken.
template <class Before, class Foresee>
u64 follow_path(Core& core, CounterexampleEnd end, const TimedPath& path, Before before, Foresee foresee) {
  core.time().wait_for_resume_at();
  bool is_sound = begins(core);
  u64 taken = 0;
  for (; is_sound && taken < path.steps.size(); ++taken) {
    const u64 choice = candidate_of(path.steps[taken].choice);
    if (core.is_timed()) foresee();
    if (!let_time_pass(core, path, taken) || choice >= core.candidate_count()) break;
    before(taken, choice);
    DrawScript script(drawn_by(path.steps[taken].choice));
    const FollowedScript follow(script);
    is_sound = core.is_timed() ? core.time().take(core.position(choice)) : core.fire(choice);
    if (!is_sound) break;
  }
  if (is_sound) (void)let_time_pass(core, path, path.steps.size());
  if (end == CounterexampleEnd::TimeLock && is_sound && !core.fault()) (void)core.time().fail_time_lock();
  return taken;
}

}  // namespace bip::rt
