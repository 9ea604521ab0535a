// Which ports are enabled, by which transition, and how that spreads through the availability network (tables.hpp).
//
// A port that becomes enabled or disabled moves the counters of the nodes above it by one; a counter that crosses zero
// makes an interaction available or unavailable, or goes on upward. What is *direct* enters the enabled set at once,
// the rest is marked and settled after the step (CoreParts::settle). Cost of a flip: O(depth), O(1) below a flat
// connector.
#pragma once
#include <utility>
#include <vector>

#include "runtime/core/link/tables.hpp"
#include "runtime/core/state/dirty_rows.hpp"

namespace bip::rt {

struct CoreParts;

struct PortState {
  // Row of Tables::transitions: the enabled one, or kNone. For simple types the only one of the port, and the place
  // from which it is enabled: their ports change with the atom's place, without being written to.
  u32 transition = kNone;
  u32 place = kNone;
};
/// What follows if an interaction's value crosses zero.
enum class Crossing : std::uint8_t {
  Marked,    // it is settled after the step
  Followed,  // rules follow at once: PriorityState::crossed
  Direct     // it comes or goes; that is all there is to know: without guards and rules
};
struct DirectInteractions {
  u32 below = 0;                                     // all interactions below are direct
  IndexVector<InteractionId, Crossing> of_crossing;  // empty: all are
  /// Of a node of the availability network; false: a group, or an interaction of which more must be known.
  [[nodiscard]] bool has(u32 node) const {
    return node < below || (node < of_crossing.size() && of_crossing[Tables::interaction_at(node)] == Crossing::Direct);
  }
};

class PortStates {
 public:
  explicit PortStates(CoreParts& core) : core_(core) {}
  /// Sizes the tables and finds the direct interactions. Once.
  void link();
  /// To the state in which no atom is anywhere and no port is enabled. O(ports + nodes).
  void reset();

  // ---- ports; an instance is a row of Tables::port_atom
  [[nodiscard]] std::size_t size() const { return ports_.size(); }
  [[nodiscard]] const PortState& port(u32 instance) const { return ports_[instance]; }
  /// Returns the row of Tables::transitions that the port would fire; kNone if it is disabled.
  [[nodiscard]] u32 enabled_row(u32 instance) const;
  /// Makes the transition (or none) the port's enabled one. Not for ports of simple types.
  void set_port(u32 instance, u32 transition);
  /// Notes that without telling what is above. Was the port disabled and is enabled, or the other way round?
  [[nodiscard]] bool exchange(u32 instance, u32 transition);
  /// Tells what is above that the port became enabled or disabled.
  void flip(u32 instance, bool on);

  // ---- the availability network
  [[nodiscard]] bool is_available(InteractionId interaction) const {
    return values_[Tables::node_of(interaction)] >= 0;
  }
  /// By node, for code that moves counters by itself: step programs and compiled steps.
  [[nodiscard]] std::int32_t* values() { return values_.data(); }
  [[nodiscard]] const DirectInteractions& direct() const { return direct_; }
  /// A counter has crossed zero: follows what that changes.
  [[gnu::noinline]] void crossed(u32 node, bool on);

  // ---- interactions that must be settled
  [[nodiscard]] DirtyRows<InteractionId>& dirty() { return dirty_; }
  [[nodiscard]] const DirtyRows<InteractionId>& dirty() const { return dirty_; }
  void mark_dirty(InteractionId interaction) { dirty_.mark(interaction); }
  /// The atom's data have changed: marks the interactions and rules that read them.
  void touch(u32 atom);

  /// Of ports; of the network.
  [[nodiscard]] std::size_t port_bytes() const { return ports_.size() * sizeof(PortState); }
  [[nodiscard]] std::size_t network_bytes() const {
    return values_.size() * sizeof(std::int32_t) + direct_.of_crossing.size() + dirty_.bytes();
  }
  /// Are the counters what the ports that are enabled now make of them? O(ports + nodes).
  [[nodiscard]] bool is_consistent() const;

 private:
  void mark_watching(u32 instance);
  void group_crossed(u32 node, bool on);

  CoreParts& core_;
  std::vector<PortState> ports_;
  std::vector<std::int32_t> values_;  // by node of the availability network
  DirectInteractions direct_;
  DirtyRows<InteractionId> dirty_;               // of no size if all are direct
  std::vector<std::pair<u32, bool>> crossings_;  // scratch
};

}  // namespace bip::rt
