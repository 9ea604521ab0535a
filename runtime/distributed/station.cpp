// See station.hpp.
#include "runtime/distributed/station.hpp"

#include <algorithm>

#include "bip/assert.hpp"

namespace bip::rt {

Station::Station(Fabric& fabric, const Codec& codec, u32 self, u32 peers)
    : fabric_(fabric), codec_(codec), self_(self) {
  BIP_ASSERT(self <= peers, "process {} of {}", self, peers);
  for (u32 peer = 0; peer < peers; ++peer) ends_.emplace_back(Link(self, peer));
}

void Station::take(const Arrival& arrival, i64 now, std::vector<ReceivedMessage>& heard) {
  if (arrival.from >= ends_.size() || arrival.from == self_ ||
      !codec_.read(arrival.bytes, arrival.from, self_, frame_)) {
    ++counts_.refused;
    return;
  }
  End& end = ends_[arrival.from];
  if (end.link.is_closed()) return;
  const bool is_first = end.last_heard == 0;
  end.last_heard = now;
  advance_clock(frame_.stamp);
  const u64 confirmed = end.link.confirmed();
  messages_.clear();
  end.link.take(frame_, messages_);
  for (Message& message : messages_) heard.push_back({arrival.from, std::move(message)});
  if (end.link.confirmed() != confirmed) {
    end.again_after = kAgainAfter;
    end.again_at = end.link.unconfirmed().empty() ? 0 : now + end.again_after;
    measure(end, frame_.number != 0, now);
    // Nothing that followed the probe had come: it was lost, too. Otherwise its confirmation was only late.
    const bool is_rest_lost = end.probe != 0 && end.link.confirmed() == end.probe;
    end.probe = 0;
    if (is_rest_lost) send_again(end, end.link.unconfirmed().size(), now);
  }
  if (end.link.owes_answer()) {
    ++end.unanswered;
    if (end.answer_at == 0) end.answer_at = now + kAnswerAfter;
  }
  // What was said before the peer was there is lost.
  if (is_first) send_again(end, end.link.unconfirmed().size(), now);
}

// Takes the round trip of the frame that is measured, if that was confirmed.
void Station::measure(End& end, bool has_messages, i64 now) {
  constexpr i64 kWeight = 8;
  if (end.measured == 0 || end.link.confirmed() < end.measured) return;
  const i64 taken = std::max<i64>(now - end.measured_at, 1);
  if (has_messages) end.round_trip += end.round_trip == 0 ? taken : (taken - end.round_trip) / kWeight;
  end.measured = 0;
}

void Station::send_frame(End& end, Frame& frame) {
  BIP_ASSERT(frame.to != self_ && &end == &ends_[frame.to], "a frame to {} of another link", frame.to);
  frame.stamp = clock_;
  bytes_.clear();
  codec_.write(frame, bytes_);
  ++counts_.frames;
  counts_.bytes += bytes_.size();
  fabric_.send(frame.to, bytes_);
  end.answer_at = 0;
  end.unanswered = 0;
}

void Station::send(i64 now) {
  for (End& end : ends_) {
    const bool must_answer = end.unanswered >= most_unanswered_;
    if (!end.link.has_unsaid() && !must_answer) continue;
    do {
      if (!end.link.next_frame(out_)) break;
      if (out_.number != 0 && end.again_at == 0) end.again_at = now + end.again_after;
      if (out_.number != 0 && end.measured == 0) {
        end.measured = out_.number;
        end.measured_at = now;
      }
      send_frame(end, out_);
    } while (end.link.has_unsaid());
  }
}

void Station::greet(u32 peer) {
  Frame frame = ends_[peer].link.greeting();
  send_frame(ends_[peer], frame);
}

// The first `count` of those that are not confirmed.
void Station::send_again(End& end, std::size_t count, i64 now) {
  if (count == 0) return;
  end.measured = 0;
  for (std::size_t k = 0; k < count; ++k) {
    Frame frame = end.link.again(k);
    ++counts_.again;
    send_frame(end, frame);
  }
  end.again_at = now + end.again_after;
}

void Station::tick(i64 now) {
  for (End& end : ends_) {
    BIP_ASSERT(end.again_at != 0 || end.link.unconfirmed().empty(), "{} frames are never sent again",
               end.link.unconfirmed().size());
    if (end.answer_at != 0 && end.answer_at <= now) {
      if (end.link.next_frame(out_)) send_frame(end, out_);
      end.answer_at = 0;
    }
    if (end.again_at != 0 && end.again_at <= now) {
      end.again_after = std::min(2 * end.again_after, kAgainAtMost);
      // One frame tells whether the others were lost: all of them would burden a peer that is only slow.
      end.probe = end.link.unconfirmed().empty() ? 0 : end.link.unconfirmed().front().number;
      if (end.probe == 0) end.again_at = 0;
      else send_again(end, 1, now);
    }
  }
}

i64 Station::due() const {
  i64 due = kForever;
  for (const End& end : ends_) {
    if (end.answer_at != 0) due = std::min(due, end.answer_at);
    if (end.again_at != 0) due = std::min(due, end.again_at);
  }
  return due;
}

void Station::close(u32 peer) {
  End& end = ends_[peer];
  end.link.close();
  end.answer_at = end.again_at = 0;
  end.probe = 0;
}

}  // namespace bip::rt
