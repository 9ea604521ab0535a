// Events in a trace of the published engine: which port for events a line of it is about, and the values that it shows.
//
// A line names the port by its path, `ROOT.panel.turn`, with or without values behind it, `(level=3;)`, or as it names
// the ports of an interaction, `ROOT.panel: turn(level=3;)`.
#pragma once
#include <optional>
#include <string_view>
#include <vector>

#include "compiler/base/result.hpp"
#include "runtime/engine/event_ports.hpp"

namespace bip::driver {

struct PublishedEvent {
  rt::u32 row = 0;                 // of EventPorts
  std::vector<EventValue> values;  // one for each variable of the port; 0, false, "" where none is shown
  bool shows_values = true;        // false: some variable has none
};

class PublishedEvents {
 public:
  /// Keeps a reference to the core's image and tables.
  explicit PublishedEvents(const rt::Core& core) : ports_(core) {}
  [[nodiscard]] const rt::EventPorts& ports() const { return ports_; }
  /// The port that a candidate or a choice is about; kNone: it is none for events. O(log ports).
  [[nodiscard]] rt::u32 find(std::string_view candidate) const;
  /// The event that the choice of such a port takes. Fails if a value is none of its variable.
  [[nodiscard]] Result<PublishedEvent> read(std::string_view chosen) const;
  /// The first word of a text that names a port for events; kNone: none does.
  [[nodiscard]] rt::u32 find_word(std::string_view text) const;

 private:
  rt::EventPorts ports_;
};

}  // namespace bip::driver
