// A process's end of all of its links, over a fabric: what is said to peers goes out in frames, what came is handed
// over in order and once. Repeats what is not confirmed in time, confirms what came if nothing else is to be said.
//
// It has the process's clock, which counts along whatever depends on something (Lamport, "Time, clocks, and the
// ordering of events in a distributed system", CACM 1978): every frame carries it. The time of day is given by who
// calls.
#pragma once
#include <algorithm>
#include <vector>

#include "runtime/core/time/interval.hpp"
#include "runtime/distributed/codec.hpp"
#include "runtime/distributed/fabric.hpp"

namespace bip::rt {

struct StationCounts {
  u64 frames = 0, again = 0, bytes = 0;
  u64 refused = 0;  // frames that are none of this run
};

struct ReceivedMessage {
  u32 from = 0;
  Message message;
};

class Station {
 public:
  static constexpr i64 kAnswerAfter = 10000000;  // ns until what came is confirmed by a frame without messages
  static constexpr i64 kAgainAfter = 200000000;  // until frames are sent again; doubles up to
  static constexpr i64 kAgainAtMost = 2000000000;
  // The same until the peer has confirmed a frame: what is sent before it is connected is lost.
  static constexpr i64 kFirstAgainAfter = 10000000;
  static constexpr u64 kMostUnanswered = 64;  // frames

  /// Links to `peers` processes; `self` is one of them, or (the launcher's) behind them. All arguments must outlive the
  /// station.
  Station(Fabric& fabric, const Codec& codec, u32 self, u32 peers);

  [[nodiscard]] const Link& link(u32 peer) const { return ends_[peer].link; }
  void say(u32 peer, Message message) { ends_[peer].link.say(std::move(message)); }
  /// Appends what is due.
  void take(const Arrival& arrival, i64 now, std::vector<ReceivedMessage>& heard);
  /// Sends what is to be said.
  void send(i64 now);
  /// Says that this process is there, also if there is nothing to say.
  void greet(u32 peer);
  /// Confirms and repeats what is due.
  void tick(i64 now);
  /// When tick has something to do; kForever: nothing.
  [[nodiscard]] i64 due() const;
  /// When something came from the peer last; 0: never.
  [[nodiscard]] i64 last_heard(u32 peer) const { return ends_[peer].last_heard; }
  /// ns from a frame to the peer until a frame that was sent after it came, smoothed (Jacobson, "Congestion avoidance
  /// and control", SIGCOMM 1988, section 2); 0: not measured yet. Of frames that are sent again nothing is taken (Karn,
  /// Partridge, SIGCOMM 1987), nor of answers without messages, which are late on purpose.
  [[nodiscard]] i64 round_trip(u32 peer) const { return ends_[peer].round_trip; }
  void close(u32 peer);
  /// Calls `take` with each row of variables of the messages that its links keep.
  template <class Take>
  void visit_kept_cells(Take take) const {
    for (const End& end : ends_) end.link.visit_kept_cells(take);
  }
  /// From now on what comes is confirmed by the next send.
  void answer_at_once() { most_unanswered_ = 1; }

  [[nodiscard]] u64 clock() const { return clock_; }
  u64 tick_clock() { return ++clock_; }
  void advance_clock(u64 least) { clock_ = std::max(clock_, least); }
  [[nodiscard]] const StationCounts& counts() const { return counts_; }

 private:
  struct End {
    explicit End(Link made) : link(std::move(made)) {}
    Link link;
    i64 last_heard = 0;
    i64 answer_at = 0;   // 0: it has its answer
    u64 unanswered = 0;  // frames
    i64 again_at = 0;    // 0: everything is confirmed
    i64 again_after = kFirstAgainAfter;
    u64 probe = 0;     // number of the frame that was sent again alone, until something is confirmed; 0: none
    u64 measured = 0;  // number of the frame whose answer is awaited; 0: none
    i64 measured_at = 0;
    i64 round_trip = 0;
  };
  static void measure(End& end, bool has_messages, i64 now);
  void send_frame(End& end, Frame& frame);
  void send_again(End& end, std::size_t count, i64 now);

  Fabric& fabric_;
  const Codec& codec_;
  u32 self_;
  u64 clock_ = 0;
  std::vector<End> ends_;
  u64 most_unanswered_ = kMostUnanswered;
  StationCounts counts_;
  // Scratch.
  Frame frame_, out_;
  std::string bytes_;
  std::vector<Message> messages_;
};

}  // namespace bip::rt
