// See network.hpp.
#include "runtime/distributed/network.hpp"

#include <algorithm>
#include <utility>

#include "bip/assert.hpp"

namespace bip::rt {

Network::Network(const NetworkFaults& faults, u64 seed) : faults_(faults), prng_(seed) {
  for (const NetworkFaults::Crash& crash : faults.crashes) {
    enter(crash.at, {NetworkEvent::Kind::Crash, crash.node, 0, {}});
    enter(crash.at + kNoticed, {NetworkEvent::Kind::Loss, crash.node, 0, {}});
  }
}

void Network::enter(i64 after, NetworkEvent event) {
  BIP_ASSERT(after >= 0, "an event {} ns ago", -after);
  if (event.kind != NetworkEvent::Kind::Crash && event.kind != NetworkEvent::Kind::Loss) ++live_;
  std::size_t row = events_.size();
  if (free_.empty()) {
    events_.push_back(std::move(event));
  } else {
    row = free_.back();
    free_.pop_back();
    events_[row] = std::move(event);
  }
  queue_.push({now_ + after, entered_++, row});
}

bool Network::is_cut(u32 a, u32 b, i64 at) const {
  return std::any_of(faults_.cuts.begin(), faults_.cuts.end(), [&](const NetworkFaults::Cut& cut) {
    return ((cut.a == a && cut.b == b) || (cut.a == b && cut.b == a)) && cut.from <= at && at < cut.until;
  });
}

i64 Network::delay(u32 from, u32 to) {
  const i64 plain = kLeastDelay + static_cast<i64>(prng_.below(static_cast<u64>(kMoreDelay)));
  return plain * std::max(faults_.slowness_of(from), faults_.slowness_of(to));
}

void Network::send(const Frame& frame) {
  BIP_ASSERT(frame.from != frame.to, "node {} sends to itself", frame.from);
  ++counts_.frames;
  const bool is_doubled = faults_.doubled_percent != 0 && prng_.below(100) < faults_.doubled_percent;
  counts_.doubled += is_doubled ? 1 : 0;
  for (int copy = 0; copy < (is_doubled ? 2 : 1); ++copy) {
    const i64 after = delay(frame.from, frame.to);
    const bool is_lost = faults_.lost_percent != 0 && prng_.below(100) < faults_.lost_percent;
    // What is on its way when the cut begins is lost, too.
    if (is_lost || is_cut(frame.from, frame.to, now_) || is_cut(frame.from, frame.to, now_ + after)) {
      ++counts_.lost;
      continue;
    }
    enter(after, {NetworkEvent::Kind::Arrival, frame.to, frame.from, frame});
  }
}

void Network::await_turn(u32 node) {
  const i64 plain = kLeastTurn + static_cast<i64>(prng_.below(static_cast<u64>(kMoreTurn)));
  enter(plain * faults_.slowness_of(node), {NetworkEvent::Kind::Turn, node, 0, {}});
}

void Network::await_again(u32 node, u32 peer) {
  enter(kAgain * std::max(faults_.slowness_of(node), faults_.slowness_of(peer)),
        {NetworkEvent::Kind::Again, node, peer, {}});
}

void Network::await_end_of_parking(u32 node, u32 peer, u64 number) {
  enter(kParked * std::max(faults_.slowness_of(node), faults_.slowness_of(peer)),
        {NetworkEvent::Kind::Parked, node, peer, {}, number});
}

void Network::tell_instant(u32 nodes) {
  i64 asked = now_;
  const auto reach = [&](u32 node, i64 from) {
    for (i64 at = from + (node == 0 ? kLeastTurn : delay(0, node));; at = from + delay(0, node)) {
      const auto cut = std::find_if(faults_.cuts.begin(), faults_.cuts.end(), [&](const NetworkFaults::Cut& named) {
        return std::min(named.a, named.b) == 0 && std::max(named.a, named.b) == node && named.from <= at &&
               at < named.until;
      });
      if (cut == faults_.cuts.end()) return at;
      from = cut->until;
    }
  };
  // There and back.
  for (u32 node = 0; node < nodes; ++node) asked = std::max(asked, reach(node, reach(node, now_)));
  for (u32 node = 0; node < nodes; ++node) enter(reach(node, asked) - now_, {NetworkEvent::Kind::Instant, node, 0, {}});
}

bool Network::next(NetworkEvent& event) {
  if (live_ == 0) return false;
  BIP_ASSERT(live_ <= queue_.size(), "{} of {} events are no crashes", live_, queue_.size());
  const Entry entry = queue_.top();
  BIP_ASSERT(entry.at >= now_, "an event at {} after one at {}", entry.at, now_);
  queue_.pop();
  now_ = entry.at;
  event = std::move(events_[entry.row]);
  free_.push_back(entry.row);
  if (event.kind != NetworkEvent::Kind::Crash && event.kind != NetworkEvent::Kind::Loss) --live_;
  return true;
}

}  // namespace bip::rt
