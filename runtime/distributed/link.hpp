// One node's end of the link to another node: every message arrives once and in order, whatever the frames that carry
// it suffer. A state machine: the caller sends, receives and knows when it is time to send again.
//
// Frames have numbers; a frame that arrives says up to which number all came, and what is not said to have come is sent
// again. O(1) a frame, but for what arrives early.
#pragma once
#include <deque>
#include <map>
#include <vector>

#include "runtime/distributed/message.hpp"

namespace bip::rt {

struct Frame {
  u32 from = 0, to = 0;
  u64 number = 0;    // 0: it carries no messages
  u64 received = 0;  // the last number up to which everything has come
  u64 stamp = 0;     // the sender's clock (station.hpp); simulated: none
  std::vector<Message> messages;
};

class Link {
 public:
  static constexpr u64 kMostEarly = 4096;             // frames: what is that far ahead is not taken
  static constexpr std::size_t kMostMessages = 1024;  // of a frame
  static constexpr std::size_t kWindow = 1024;        // unconfirmed frames: then messages wait

  Link(u32 self, u32 peer) : self_(self), peer_(peer) {}

  /// Says the message with the next frame.
  void say(Message message) { unsaid_.push_back(std::move(message)); }
  /// The next frame: with all that is unsaid, or to say what came. False: there is nothing to say.
  bool next_frame(Frame& frame);
  /// A frame without messages, to be heard of.
  [[nodiscard]] Frame greeting() const { return {self_, peer_, 0, received_, 0, {}}; }
  /// Takes a frame of the peer; appends the messages that are due now.
  void take(const Frame& frame, std::vector<Message>& messages);
  /// Frames that may not have come.
  [[nodiscard]] const std::deque<Frame>& unconfirmed() const { return unconfirmed_; }
  [[nodiscard]] bool has_unsaid() const { return !unsaid_.empty() && unconfirmed_.size() < kWindow; }
  [[nodiscard]] std::size_t unsaid() const { return unsaid_.size(); }
  [[nodiscard]] bool owes_answer() const { return owes_answer_; }
  /// Number of the next frame; what is said now is in this frame or a later one.
  [[nodiscard]] u64 next_number() const { return next_; }
  /// Up to this frame everything has come.
  [[nodiscard]] u64 confirmed() const { return unconfirmed_.empty() ? next_ - 1 : unconfirmed_.front().number - 1; }
  [[nodiscard]] bool is_closed() const { return is_closed_; }
  /// Such a frame as it is sent again.
  [[nodiscard]] Frame again(std::size_t k) const;
  /// The peer is gone: there is nothing to say to it any more.
  void close();
  /// Calls `take` with each row of variables of the messages that it keeps.
  template <class Take>
  void visit_kept_cells(Take take) const {
    visit_cells(unsaid_, take);
    for (const Frame& frame : unconfirmed_) visit_cells(frame.messages, take);
    for (const auto& [number, messages] : early_) visit_cells(messages, take);
  }

 private:
  u32 self_, peer_;
  u64 next_ = 1;      // number of the next frame
  u64 received_ = 0;  // up to here everything has come
  bool owes_answer_ = false;
  bool is_closed_ = false;
  std::vector<Message> unsaid_;
  std::deque<Frame> unconfirmed_;
  std::map<u64, std::vector<Message>> early_;
};

}  // namespace bip::rt
