// A run-time error (an R code): data about where and what, and its text. The run stops at a fault.
#pragma once
#include <cstdint>
#include <functional>
#include <string>

#include "bip/image.hpp"

namespace bip::rt {

enum class FaultCode : std::uint8_t {
  None,
  TwoTransitions,       // R0001 two enabled transitions of the same port
  TwoInternals,         // R0002 two internal transitions enabled
  NotOneSafe,           // R0003 a token put on a marked place
  EndlessInternals,     // R0004
  DivisionByZero,       // R0005
  DivisionOverflow,     // R0006 INT_MIN / -1
  InvariantViolated,    // R0007
  PriorityCycle,        // R0008
  TooManyInteractions,  // R0009
  AtomPriorityCycle,    // R0010
  Exception,            // R0011 a C++ function threw
  TimeLock,             // R0020 neither a step nor time can go on
  BadClock,             // R0021 a clock is set to what is no value or speed of one
  LateStep,             // R0022 real time: a step that starts when its guard no longer allows it
  EventRefused,         // R0023 an event from outside came to a port that says `error` and could not take it
  SourceFailed,         // R0024 a C++ class behind a port for events threw
  ReplayDiffers,        // R0025 a run that is replayed is no longer what was recorded
  BadDraw,              // R0070 arguments that are none of the distribution's
  UntriedDraw           // R0071 a search cannot take all values of a draw
};
[[nodiscard]] const char* name_of(FaultCode code);  // "R0001"
/// The exit number of the published engine for the fault; 1 for those it does not know.
[[nodiscard]] int published_exit_code(FaultCode code);

struct Fault {
  FaultCode code = FaultCode::None;
  std::uint32_t atom = kNone;
  std::uint32_t connector = kNone;
  std::uint32_t port = kNone;  // of the atom's type
  SourceLine loc{};            // line 0: none
  SourceLine other{};          // the second transition
  std::string what;            // one line, names paths, ports and places
  std::string rule;            // the invariant, or the priorities of a cycle
  std::string places;          // of the atom, "A, B"
  std::string data;            // of the atom, "x = 1, b = true"
  // The step is done: places, data and clocks are those of the state that it leads to, whose candidates cannot be
  // found.
  bool is_of_state = false;
  [[nodiscard]] explicit operator bool() const { return code != FaultCode::None; }
};

class Core;
/// The core's fault as the tools print it, with the instant if the model has time: several lines with a newline at the
/// end. `show_source`: as in RunOptions.
[[nodiscard]] std::string fault_text(const Core& core, std::uint64_t seed, std::uint64_t step,
                                     const std::function<std::string(SourceLine)>& show_source = {});

}  // namespace bip::rt
