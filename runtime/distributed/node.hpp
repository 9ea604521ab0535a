// A node of a distributed run, as a state machine: messages come in, messages go out, and in between it says which
// steps it may begin and which actions wait to be run. No input or output, no clock, no thread; the caller decides
// when.
//
// It has a core of the whole image. Atoms at home here have their data in it. What it coordinates it begins as the core
// allows: atoms that are elsewhere, or offered elsewhere, are away, so all that depends on them waits
// (core/fire/partial.hpp). A step that it begins runs here for the atoms at home here, and is a BEGIN for others;
// an atom that comes to rest is offered to the one node that coordinates what it can do next.
#pragma once
#include <functional>
#include <utility>
#include <vector>

#include "runtime/core/core.hpp"
#include "runtime/distributed/distribution.hpp"
#include "runtime/distributed/message.hpp"

namespace bip::rt {

struct NodeCounts {
  u64 offers = 0, begins = 0;  // messages sent
  u64 stale = 0;               // messages that came again
};

/// What happens to an atom, as models/protocol/offer_begin.bip tells it.
struct NodeEvent {
  enum class Kind : std::uint8_t {
    Begun,    // its coordinator begins a step with it
    Taken,    // its home takes the step
    Rested,   // it is at rest again
    Offered,  // its home offers it
    Received  // its coordinator has the offer
  };
  Kind kind = Kind::Begun;
  u32 atom = kNone;
};
using NodeObserver = std::function<void(NodeEvent)>;

class Node {
 public:
  /// All arguments must outlive the node.
  Node(const Image& image, const CoreOptions& options, const Distribution& distribution, u32 self)
      : distribution_(distribution), self_(self), core_(image, options) {}

  [[nodiscard]] Core& core() { return core_; }
  /// To the initial state, which all nodes know. False: a fault.
  bool start(const State& state);

  /// Is told what happens from now on; for tests.
  void observe(NodeObserver observer) { observer_ = std::move(observer); }
  /// Takes a message of another node.
  void take(const Message& message);
  /// Begins a candidate that is_decided, as step `step` of the whole run: numbers grow along whatever depends on
  /// something. Appends the atoms that take part.
  void begin(EnabledSet::Position at, u64 step, std::vector<u32>& atoms);
  /// Actions that wait to be run.
  [[nodiscard]] std::size_t work_count() const { return works_.size(); }
  /// Runs one of them and lets it take effect.
  void run(std::size_t k);

  /// Messages to send, in this order; the sender empties it.
  [[nodiscard]] std::vector<Outgoing>& outbox() { return outbox_; }
  /// Steps of which an atom came to rest here; the reader empties it.
  [[nodiscard]] std::vector<u64>& landed() { return landed_; }
  /// A fault was met, here or elsewhere: it begins nothing more.
  [[nodiscard]] bool is_stopped() const { return is_stopped_; }
  [[nodiscard]] const NodeCounts& counts() const { return counts_; }
  /// Writes places and data of the atoms at home here into a state of the image.
  void save(State& state) const;
  /// NextMove::history of an atom at home here.
  [[nodiscard]] u32 history(u32 atom) const { return history_[atom]; }

 private:
  void take(const Offer& offer);
  void take(const Begin& begin);
  void take(const Stop&) { is_stopped_ = true; }
  void take(const Control&) {}
  void come_to_rest(u32 atom);
  void note_history(u32 atom, const LinkedTransition& transition, u32 interaction);
  bool find_coordinator(u32 atom, u32& coordinator);
  void stop();
  void tell(NodeEvent::Kind kind, u32 atom) const {
    if (observer_) observer_({kind, atom});
  }

  const Distribution& distribution_;
  u32 self_;
  Core core_;
  std::vector<u64> n_;        // by atom: at home, how often it took part; elsewhere, as its last offer said
  std::vector<u32> history_;  // by atom at home: the connector that tells its next moves apart (NextMove)
  std::vector<Work> works_, begun_;
  std::vector<Outgoing> outbox_;
  std::vector<u64> landed_;
  std::vector<u32> enabled_;  // scratch: ports
  NodeCounts counts_;
  NodeObserver observer_;
  bool is_stopped_ = false;
};

}  // namespace bip::rt
