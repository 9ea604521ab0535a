// Time in an image: what a type of atoms has to do with it (semantics.md, Time). A type without any of it has none of
// these tables, and an image without such a type costs nothing.
//
// Times are counted in ticks of 1 ns. Code knows no clocks: an action that sets one writes the value, in the clock's
// unit, into a hidden variable and true into the next; a limit that is no constant is put into a hidden variable by
// `measure`, an action.
#pragma once
#include "bip/image_tables.hpp"

namespace bip::rt {

struct Clock {
  const char* name;
  std::int64_t unit;       // ticks
  std::uint32_t variable;  // float: what it is set to; the next, bool: that it is; the one after, float: its speed
  SourceLine loc;
  bool is_read = false;  // an action reads `variable`: it holds the clock's value while the action runs
};
enum class BoundOp : std::uint8_t { Lt, Le, Gt, Ge, Eq };
/// clock - minus op limit
struct Bound {
  std::uint32_t clock, minus;  // of the type; minus: kNone, or of the same unit
  BoundOp op;
  std::int64_t ticks;      // the limit, if variable is kNone
  std::uint32_t variable;  // float, in the clock's unit
};
struct TimeGuard {
  Span<Bound> bounds;
  std::uint32_t measure;  // row of Image::codes or kNone
};
enum class Urgency : std::uint8_t { Lazy, Delayable, Eager };
struct Resume {
  bool present;
  std::uint32_t guard;  // row of Image::codes or kNone
  TimeGuard when;
};
/// The action runs beside the others; the atom is busy until it returns.
struct Async {
  bool present = false;
  std::int64_t budget = -1;       // ticks; -1: none
  std::uint32_t overrun = kNone;  // a port for events, without variables
};
struct TransitionTime {
  TimeGuard when;
  Urgency urgency;
  Resume resume;
  Async async = {};
};
enum class EventPolicy : std::uint8_t { Remember, Ignore, Error };
/// A port whose transitions wait for an event from outside.
struct EventPort {
  std::uint32_t port;
  EventPolicy policy;
  const char* event_class;  // C++; "" if none was named
  std::uint32_t source;     // row of Image::event_classes; kNone: events come from files and programs only
};
struct AtomTime {
  Span<Clock> clocks;
  Span<TransitionTime> transitions;  // one a transition of the type
  Span<TimeGuard> invariants;        // one an invariant
  Resume initial;
  Span<EventPort> events;
};

/// Returns how many variables of the type are the model's own: those of clocks and of the generator come after them.
constexpr std::uint32_t visible_variables(const AtomType& type) {
  const bool has_clocks = type.time != nullptr && type.time->clocks.size != 0;
  const std::uint32_t before_clocks = has_clocks ? type.time->clocks[0].variable : type.variables.size;
  return type.draws < before_clocks ? type.draws : before_clocks;
}

/// What an object of a C++ class may ask of the engine, from any thread.
struct SourceContext {
  const char* port;  // "ROOT.panel.press"
  void* engine;
  void (*notify)(void* engine);
  std::int64_t (*now)(void* engine);
};
enum class Poll : std::uint8_t { None, Event, Exception };
/// A class behind a port for events (event_source.hpp). Nothing throws: what an exception said is the FfiContext's
/// message.
struct EventClass {
  const char* name;
  /// A new object, initialized; null after an exception.
  void* (*make)(const SourceContext& context, FfiContext& ffi);
  /// Takes the first event if its instant is no later than `until`: the instant and the values.
  Poll (*poll)(void* object, FfiContext& ffi, std::int64_t now, std::int64_t until, std::int64_t& time, Cell* values);
  bool (*purge)(void* object, FfiContext& ffi);  // false after an exception
  void (*destroy)(void* object);
};

}  // namespace bip::rt
