// See link.hpp.
#include "runtime/distributed/link.hpp"

#include <iterator>
#include <utility>

#include "bip/assert.hpp"

namespace bip::rt {

bool Link::next_frame(Frame& frame) {
  if (is_closed_ || (!has_unsaid() && !owes_answer_)) return false;
  frame = {self_, peer_, 0, received_, 0, {}};
  owes_answer_ = false;
  if (!has_unsaid()) return true;
  frame.number = next_++;
  if (unsaid_.size() <= kMostMessages) {
    frame.messages = std::move(unsaid_);
    unsaid_.clear();
  } else {
    const auto end = unsaid_.begin() + kMostMessages;
    frame.messages.assign(std::make_move_iterator(unsaid_.begin()), std::make_move_iterator(end));
    unsaid_.erase(unsaid_.begin(), end);
  }
  BIP_ASSERT(unconfirmed_.empty() || unconfirmed_.back().number + 1 == frame.number, "frame {} follows {}",
             frame.number, unconfirmed_.back().number);
  unconfirmed_.push_back(frame);
  BIP_ASSERT(unconfirmed_.size() <= kWindow, "{} frames are not confirmed", unconfirmed_.size());
  return true;
}

void Link::take(const Frame& frame, std::vector<Message>& messages) {
  if (is_closed_) return;
  while (!unconfirmed_.empty() && unconfirmed_.front().number <= frame.received) unconfirmed_.pop_front();
  if (frame.number == 0) return;
  owes_answer_ = true;
  if (frame.number > received_ && frame.number - received_ <= kMostEarly) early_.emplace(frame.number, frame.messages);
  for (auto next = early_.begin(); next != early_.end() && next->first == received_ + 1; next = early_.begin()) {
    for (Message& message : next->second) messages.push_back(std::move(message));
    early_.erase(next);
    ++received_;
  }
  BIP_ASSERT(early_.empty() || (early_.begin()->first > received_ + 1 && early_.size() < kMostEarly),
             "frame {} waits, and all up to {} came", early_.begin()->first, received_);
}

Frame Link::again(std::size_t k) const {
  BIP_ASSERT(k < unconfirmed_.size(), "frame {} of {}", k, unconfirmed_.size());
  Frame frame = unconfirmed_[k];
  frame.received = received_;
  return frame;
}

void Link::close() {
  is_closed_ = true;
  unsaid_.clear();
  unconfirmed_.clear();
}

}  // namespace bip::rt
