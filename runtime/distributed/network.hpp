// A simulated network: frames and moments of nodes in the order of a simulated time, with delays, reordering, losses,
// duplicates and cuts drawn from a seed. The same seed and the same calls give the same run.
//
// O(log events) an event.
#pragma once
#include <queue>
#include <vector>

#include "bip/prng.hpp"
#include "runtime/distributed/faults.hpp"
#include "runtime/distributed/link.hpp"

namespace bip::rt {

struct NetworkEvent {
  enum class Kind : std::uint8_t {
    Arrival,  // of `frame`
    Turn,     // `node` does what is next
    Again,    // `node` looks whether its frames to `peer` have come
    Instant,  // `node` hears that time passes
    Parked,   // an attempt that waits at `node` has waited long enough
    Crash,    // `node` is gone
    Loss      // the others learn that `node` is gone
  };
  Kind kind = Kind::Turn;
  u32 node = 0, peer = 0;
  Frame frame;
  u64 number = 0;  // Parked: Node::Parking
};

struct NetworkCounts {
  u64 frames = 0, again = 0, lost = 0, doubled = 0;
};

class Network {
 public:
  static constexpr i64 kLeastDelay = 500000, kMoreDelay = 1000000;    // ns, of a frame
  static constexpr i64 kLeastTurn = 20000, kMoreTurn = 60000;         // of what a node does in one go
  static constexpr i64 kAgain = 50000000;                             // until a frame is sent again
  static constexpr i64 kParked = 3 * (kLeastDelay + kMoreDelay / 2);  // what the messages of a refusal take
  static constexpr i64 kNoticed = 50000000;                           // until a crash is known

  Network(const NetworkFaults& faults, u64 seed);

  void send(const Frame& frame);
  void send_again(const Frame& frame) {
    ++counts_.again;
    send(frame);
  }
  /// The node's next turn, when it has done what takes its time.
  void await_turn(u32 node);
  void await_again(u32 node, u32 peer);
  /// The end of the parking of that number at the node, of an attempt that comes from the peer.
  void await_end_of_parking(u32 node, u32 peer, u64 number);
  /// Sends the next instant of a model with time to all nodes; each receives it after a delay of its own. The sender
  /// computes it beside the first node, from answers of the others, so a cut delays it for the nodes behind the cut.
  void tell_instant(u32 nodes);
  /// The next event. False: nothing will happen any more, but for crashes.
  bool next(NetworkEvent& event);
  /// Calls `take` with each row of variables that is on its way.
  template <class Take>
  void visit_kept_cells(Take take) const {
    for (const NetworkEvent& event : events_) visit_cells(event.frame.messages, take);
  }
  [[nodiscard]] i64 now() const { return now_; }
  [[nodiscard]] const NetworkCounts& counts() const { return counts_; }

 private:
  struct Entry {
    i64 at;
    u64 number;  // of equal instants the first entered comes first
    std::size_t row;
    bool operator>(const Entry& other) const { return at != other.at ? at > other.at : number > other.number; }
  };
  void enter(i64 after, NetworkEvent event);
  [[nodiscard]] bool is_cut(u32 a, u32 b, i64 at) const;
  [[nodiscard]] i64 delay(u32 from, u32 to);

  const NetworkFaults& faults_;
  Prng prng_;
  i64 now_ = 0;
  u64 entered_ = 0;
  std::size_t live_ = 0;  // events that are no crashes
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
  std::vector<NetworkEvent> events_;
  std::vector<std::size_t> free_;
  NetworkCounts counts_;
};

}  // namespace bip::rt
