// See timed_scheduler.hpp. Cost of a state: O(log atoms) an instant that is passed; if instants are planned, the
// candidates and their participants.
#include "runtime/engine/timed_scheduler.hpp"

#include <algorithm>

#include "bip/assert.hpp"
#include "runtime/core/time/draw_instant.hpp"
#include "runtime/engine/policies.hpp"

namespace bip::rt {

namespace {

i64 mean_of(i64 unit, double weight) {
  const double mean = static_cast<double>(unit) / weight;
  return mean < 1 ? 1 : mean > static_cast<double>(kForever / 4) ? kForever / 4 : static_cast<i64>(mean);
}
double weight_of_tie(double share, double total) { return share * total; }

}  // namespace

bool draws_resumes(const Image& image, const RunOptions& options) {
  const bool plans = row_of(options.policy).is_uniform() && !options.asap && !options.interactive;
  if (!plans || options.speed > 0 || !options.draws_resumes || has_nodes(options.engine)) return false;
  for (const Atom& atom : image.atoms) {
    const AtomTime* time = image.atom_types[atom.type].time;
    if (time != nullptr && has_resume(*time)) return true;
  }
  return false;
}

// The earliest plan, and whose it is; false if it is not before the next change.
bool TimedScheduler::plan(Core& core, i64 last) {
  at_ = kForever;
  std::uint64_t ties = 0;
  const bool is_weighted = core.weights().any();
  double weight_of_ties = 0;
  for (std::uint64_t k = 0; k < ends_.size(); ++k) {
    BIP_ASSERT(ends_[k] >= core.now(), "candidate {} ended at {}", k, ends_[k]);
    // A weight is a rate: of two waiting times without end the heavier one is shorter.
    const double weight = is_weighted ? core.weights().weight(core.position(k)) : 1;
    const i64 instant = draw_instant(prng_, core.now(), std::min(ends_[k], last), mean_of(core.time().unit(), weight));
    if (instant > at_) continue;
    if (is_weighted) {
      weight_of_ties = instant == at_ ? weight_of_ties + weight : weight;
      const bool is_alone = weight_of_ties == weight;
      at_ = instant;
      if (is_alone || weight_of_tie(prng_.share(), weight_of_ties) < weight) choice_ = core.position(k);
      continue;
    }
    ties = instant == at_ ? ties + 1 : 1;
    at_ = instant;
    // Of those that plan the same instant each is as likely.
    if (ties != 1 && prng_.below(ties) != 0) continue;
    choice_ = core.position(k);
  }
  return at_ < core.time().next_change();
}

i64 TimedScheduler::latest(Core& core) {
  const i64 last = core.time().wait_limit(ends_);
  BIP_ASSERT(core.enabled().number(choice_) < ends_.size(), "candidate {}", core.enabled().number(choice_));
  return std::min(ends_[core.enabled().number(choice_)], last);
}

inline TimedScheduler::Next TimedScheduler::look(Core& core) {
  at_ = core.now();
  const bool has_candidates = core.candidate_count() != 0;
  if (has_candidates && !plans_) {
    choice_ = scheduler_.choose(core);
    return Next::Step;
  }
  const i64 last = core.time().wait_limit(ends_);
  if (has_candidates && plan(core, last)) return Next::Step;
  const i64 next = core.time().next_change();
  BIP_ASSERT(next > core.now() && last >= core.now(), "the next change is at {}, time may pass until {}", next, last);
  at_ = std::min(next, last);
  if (next > last) return Next::Lock;
  return next == kForever ? Next::Never : Next::Change;
}

Due TimedScheduler::wait(Core& core, EventFeed& feed) {
  if (!core.is_timed()) {
    if (core.candidate_count() == 0) return Due::Deadlock;
    choice_ = scheduler_.choose(core);
    return Due::Step;
  }
  while (true) {
    const Next next = look(core);
    BIP_ASSERT(at_ >= core.now(), "from {} back to {}", core.now(), at_);
    BIP_ASSERT(next != Next::Step || core.enabled().has(choice_) || at_ != core.now(), "a choice that is no candidate");
    if (const i64 event = feed.wait(core, at_); event != kForever) {
      if (event > core.now() && !core.time().advance(event)) return Due::Fault;
      return feed.deliver(core) ? Due::Event : Due::Fault;
    }
    if (feed.failed()) return Due::Fault;
    if (feed.is_stopped()) return Due::Stopped;
    if (next == Next::Never) return Due::Deadlock;
    if (next == Next::Lock) {
      // There is no candidate, and time cannot pass to an instant that has one.
      (void)core.time().fail_time_lock();
      return Due::Fault;
    }
    if (at_ != core.now() && !core.time().advance(at_)) return Due::Fault;
    if (next == Next::Step) return Due::Step;
  }
}

}  // namespace bip::rt
