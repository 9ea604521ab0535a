// See future.hpp.
#include "runtime/trace/future.hpp"

#include <algorithm>

#include "bip/assert.hpp"

namespace bip::rt {

namespace {

// The last instant to which time may pass in this state, and whether a strict bound of a delayable step ends it.
struct Last {
  i64 at = kForever;
  bool is_open = false;
};
Last last_instant(Core& core) {
  Last last{core.time().last_instant(), false};
  for (std::uint64_t k = 0; k < core.candidate_count() && last.at > core.now(); ++k) {
    const CandidateTime time = core.time().time_of(core.candidate(k));
    if (time.urgency == Urgency::Eager) last = {core.now(), false};
    else if (time.urgency == Urgency::Delayable && time.interval.high < last.at)
      last = {time.interval.high, time.interval.high_open};
  }
  if (last.at < core.now() || (last.at > core.now() && core.time().is_before_eager())) last = {core.now(), false};
  return last;
}

// Has a candidate just come to its end, and that end belongs to it?
bool has_just_ended(const std::vector<FutureCandidate>& all, i64 now) {
  return std::any_of(all.begin(), all.end(), [now](const FutureCandidate& f) {
    return !f.intervals.empty() && f.intervals.back().high == now - 1 && !f.intervals.back().high_open;
  });
}

}  // namespace

std::vector<FutureCandidate> future_candidates(Core& core,
                                               const std::function<void(std::string&, Core&, const Candidate&)>& tell) {
  BIP_ASSERT(core.is_timed(), "a model without time has no later candidates");
  const State state = core.snapshot();
  const std::vector<InteractionId> order = core.enabled().list_order();
  std::vector<FutureCandidate> all;
  Last until;
  for (int instants = 0; instants < kMaxInstants; ++instants) {
    const i64 now = core.now();
    if (const Last last = last_instant(core); last.at < until.at) until = last;
    const i64 next = core.time().next_change();
    const i64 end = std::min(until.at, next == kForever ? kForever : next - 1);
    const bool ended = has_just_ended(all, now);
    for (std::uint64_t k = 0; k < core.candidate_count(); ++k) {
      const Candidate candidate = core.candidate(k);
      std::string text;
      tell(text, core, candidate);
      auto known = std::find_if(all.begin(), all.end(), [&](const FutureCandidate& f) {
        return f.interaction == candidate.interaction && f.text == text;
      });
      if (known == all.end()) {
        all.push_back({std::move(text), candidate.connector == kNone, candidate.interaction, {}});
        known = all.end() - 1;
      }
      Interval interval = core.time().time_of(candidate).interval;
      // It may have been one before, or go on after the next change; a dominating one may end it there.
      const bool goes_on = !known->intervals.empty() && known->intervals.back().high == now - 1;
      // What begins because something else ended, or ends because something else begins, leaves that instant out.
      interval.low_open = instants > 0 && (interval.low_open || ended);
      interval.low = now;
      if (interval.high > end) interval.high = end, interval.high_open = end < until.at || until.is_open;
      BIP_ASSERT(known->intervals.empty() || known->intervals.back().low <= interval.low,
                 "an interval before the last");
      if (goes_on) known->intervals.back().high = interval.high, known->intervals.back().high_open = interval.high_open;
      else known->intervals.push_back(interval);
    }
    if (next > until.at || next == kForever || !core.time().advance(next)) break;
  }
  (void)core.restore(state);
  BIP_ASSERT(core.snapshot().places == state.places && core.snapshot().time == state.time,
             "the restored state is another one");
  core.set_list_order(order);
  BIP_ASSERT(core.enabled().list_order() == order, "the list that uniform draws from is another one");
  std::stable_sort(all.begin(), all.end(),
                   [](const FutureCandidate& a, const FutureCandidate& b) { return a.interaction < b.interaction; });
  BIP_ASSERT(core.now() <= until.at || all.empty(), "time may pass until {}", until.at);
  return all;
}

}  // namespace bip::rt
