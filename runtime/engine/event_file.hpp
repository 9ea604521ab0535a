// Events in a file, one a line of JSON, in the order in which they come (semantics.md, Events). Written by --record,
// read by
// --events and `bipc replay`.
#pragma once
#include <string>
#include <vector>

#include "bip/result.hpp"
#include "bip/run.hpp"
#include "runtime/engine/event_ports.hpp"

namespace bip::rt {

inline constexpr u64 kAnyLook = ~u64{0};
/// Return, Overrun: the action of an atom that runs beside the others (`@async`) has ended; its budget has. Resume: so
/// long did the actions of the last step take that `resume` holds.
enum class EventKind : std::uint8_t { Port, Return, Overrun, Resume };
/// An event for a row of EventPorts, or of an atom.
struct Event {
  i64 time = 0;
  u32 row = 0;          // of the ports; Return, Overrun: the atom
  u64 look = kAnyLook;  // replay: how often the engine had looked for its next step when it came
  std::vector<EventValue> values;
  EventKind kind = EventKind::Port;
  u64 job = 0;    // Return: its number in the pool
  i64 until = 0;  // Resume: the instant at which they returned
};

/// What the first and the last line of a record say of the run: replay needs it.
struct Record {
  bool has_end = false;  // false: the run was cut off
  std::string model;
  u64 seed = 0;
  Policy policy = Policy::Uniform;
  bool asap = false, maximal_progress = true;
  bool draws_resumes = false;  // of busy atoms, by the seed
  bool tells_returns = false;  // of actions that run beside the others
  End end = End::Limit;
  u64 steps = 0, looks = 0;
  bool is_torn = false;  // the last line is incomplete: the run was cut off while it was written
};
/// Reads the first and the last line of a record; a failure names the file and the line.
[[nodiscard]] Result<Record> read_record(const std::string& path);
void append_record_head(std::string& out, const Record& record);
void append_record_end(std::string& out, const Record& record);

enum class EventSource : std::uint8_t { Script, Record };
/// All events of the file; only records tell of actions. A failure names the file and the line. While a pipe has no
/// events, `is_stopped` is asked: true is a failure. Null: it is waited for, however long.
[[nodiscard]] Result<std::vector<Event>> read_events(const std::string& path, const EventPorts& ports,
                                                     EventSource source, bool (*is_stopped)() = nullptr);
/// A line with its newline.
void append_event(std::string& out, const EventPorts& ports, const Event& event);

/// `1s500ms`, `20us`, `0`: ns; -1: it is none.
[[nodiscard]] i64 parse_time(std::string_view text);

}  // namespace bip::rt
