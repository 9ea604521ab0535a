// Events from outside in the core: what waits at a port, which atoms may take it, what happens to events that none can
// take.
//
// A port for events is enabled while a transition of it is and an event waits; the step that takes the event writes its
// values into the port's variables, then fires. In a state in which no transition of the port is enabled, events that
// wait there are kept, dropped or an error, as the port says. Where events come from is the engine's matter. Cost: a
// look at the atom for each event that finds the queue empty; nothing for images without such ports.
#pragma once
#include <string>
#include <vector>

#include "bip/image_time.hpp"
#include "runtime/core/fire/fault.hpp"
#include "runtime/core/link/tables.hpp"
#include "runtime/core/time/interval.hpp"

namespace bip::rt {

struct CoreParts;

/// A port for events of one atom.
struct EventPortRow {
  u32 atom = 0, port = 0;
  u32 width = 0;  // values an event carries
  EventPolicy policy = EventPolicy::Remember;
  u32 source = kNone;  // row of Image::event_classes
};
/// Events that came and were not taken, first come first taken. A part of the state.
struct EventQueue {
  u32 count = 0;
  u32 first = 0;  // row of `values` of the first one
  std::vector<Cell> values;
};

class EventQueues {
 public:
  explicit EventQueues(CoreParts& core) : core_(core) {}
  /// Lists the ports. Once, of images with time.
  void link();
  /// Empties the queues.
  void reset() { queues_.assign(ports_.size(), {}); }

  /// The atoms' ports for events, in canonical order; a row is how others name one. Empty in images without.
  [[nodiscard]] const std::vector<EventPortRow>& ports() const { return ports_; }
  [[nodiscard]] bool empty() const { return ports_.empty(); }
  [[nodiscard]] bool is_event_port(u32 atom, u32 port) const;
  /// An event comes at this instant, with one value for each variable of the port's type. False: a fault.
  bool deliver(u32 row, const Cell* values);
  /// How many events came to the port and were not taken.
  [[nodiscard]] u32 waiting(u32 row) const { return queues_[row].count; }
  /// A variable of a port as a step shows it: of a port for events what the event brings.
  [[nodiscard]] const Cell& shown(u32 atom, u32 port, u32 variable) const;
  /// Makes a fault of what has gone wrong outside, at this instant. Always false.
  bool fail_outside(FaultCode code, const std::string& what);

  // ---- for the other parts of the core; an instance is a row of Tables::port_atom
  /// Is it a port for events at which none waits?
  [[nodiscard]] bool is_without_event(u32 instance) const {
    const u32 row = row_of(instance);
    return row != kNone && queues_[row].count == 0;
  }
  /// Moves the first event's values into the port's variables; nothing for other ports.
  void take(u32 instance);
  /// Drops what waits at ports that cannot take it and do not keep it, or makes a fault of it: false.
  /// transition_of_port: what is enabled in this state, before the atom's priorities.
  bool refuse(u32 atom, const u32* transition_of_port);
  /// Appends of each port how many events wait, and their values; reads the same, and returns what follows.
  void save(std::vector<i64>& out) const;
  const i64* load(const i64* in);
  /// Of all rows.
  [[nodiscard]] std::size_t bytes() const;

 private:
  [[nodiscard]] u32 row_of(u32 instance) const { return row_of_port_.empty() ? kNone : row_of_port_[instance]; }
  bool fail_event(u32 row);

  CoreParts& core_;
  std::vector<EventPortRow> ports_;
  std::vector<u32> row_of_port_;    // by port instance: row of ports_, or kNone; empty if there are none
  std::vector<EventQueue> queues_;  // by row of ports_
};

}  // namespace bip::rt
