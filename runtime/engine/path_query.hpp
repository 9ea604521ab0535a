// A question about one run that is true or false of it: `stays` holds until `goal` does, within bounds.
//
// The core is looked at in each stable state, once it is entered. The answer is known at the first state in which the
// goal holds (yes), or `stays` does not hold, or that is beyond the bounds (no). A run that ends repeats its last state
// for ever: then the goal is never reached.
#pragma once
#include <cstdint>
#include <functional>

#include "runtime/core/core.hpp"

namespace bip::rt {

struct PathQuery {
  std::function<bool(const Core&)> stays;  // null: true
  std::function<bool(const Core&)> goal;
  bool is_negated = false;  // `G E` is not (true U not E)
  std::uint64_t most_steps = ~std::uint64_t{0};
  i64 until = kForever;  // of the model's time, this instant included

  [[nodiscard]] bool is_bounded() const { return most_steps != ~std::uint64_t{0} || until != kForever; }
};
enum class Answer : std::uint8_t { Open, No, Yes };

[[nodiscard]] inline Answer negated(Answer answer, bool is_negated) {
  if (!is_negated || answer == Answer::Open) return answer;
  return answer == Answer::Yes ? Answer::No : Answer::Yes;
}
/// The answer in a state that was entered after `steps` steps; Open: later ones decide.
[[nodiscard]] inline Answer answer_in(const PathQuery& query, const Core& core, std::uint64_t steps) {
  Answer found = Answer::Open;
  if (steps > query.most_steps || (core.is_timed() && core.now() > query.until)) found = Answer::No;
  else if (query.goal(core)) found = Answer::Yes;
  else if ((query.stays && !query.stays(core)) || steps == query.most_steps) found = Answer::No;
  return negated(found, query.is_negated);
}
/// The answer of a run that has ended without a fault and was open: nothing happens any more.
[[nodiscard]] inline Answer answer_at_end(const PathQuery& query) { return negated(Answer::No, query.is_negated); }

}  // namespace bip::rt
