// Reads the text trace of the published engine (and of --trace-format=bip2).
//
// Relevant lines begin with `[BIP ENGINE]: `; output of the model in between is skipped. A state consists of its
// candidates and of the choice; the last state may be a deadlock, a time lock or be truncated anywhere, and an error
// may end the run, before the first state, too. The engine for real time writes instants and intervals of models
// without time as well.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/base/result.hpp"

namespace bip::driver {

/// How a trace says that the run ended. Error: with one that has no kind of its own. CutError: with one whose line was
/// cut off.
enum class TraceEnd : std::uint8_t {
  None,
  Deadlock,
  TimeLock,
  TwoTransitions,
  NotOneSafe,
  Invariant,
  PriorityCycle,
  Event,
  Late,
  Error,
  CutError
};

struct TraceState {
  std::uint64_t number = 0;
  std::size_t line = 0;                 // of its first line, from 1
  std::vector<std::string> candidates;  // without "[k] ", with their intervals
  std::string chosen;                   // empty: none
  std::size_t chosen_rank = 0;          // among the candidates of that text: how many stand before it
  std::string entered;                  // "1s", the state's global time; empty: the trace has no time
  std::string instant;                  // "1s500ms", when it was taken; empty: the trace has no time
  bool is_deadlock = false;
  bool is_complete = false;  // as many candidates as its first line says
};

struct PublishedTrace {
  std::vector<TraceState> states;
  TraceEnd end = TraceEnd::None;
  std::size_t end_line = 0;
  std::string end_text;     // "invariant ROOT.a.i violated!"
  std::string end_instant;  // "1s600ms", of the line that says of the last state how the run ended; empty: none does
  // What the line of the end names; empty: nothing.
  std::string end_component;        // "ROOT.a", in which an invariant or a Petri net is violated
  std::string end_invariant;        // "i"
  std::string end_lock;             // "5s", at which time stands still
  bool ends_behind_choice = false;  // no state and no end follow the last choice: the run was cut off there
};

/// Fails if neither a state nor an end is found or a line of a state, unless it is the text's last, cannot be read; the
/// message names the line.
[[nodiscard]] Result<PublishedTrace> read_published_trace(std::string_view text);

/// A candidate without the intervals behind it.
[[nodiscard]] std::string without_intervals(std::string_view candidate);

/// A candidate in the form in which two engines' are compared: white space, truth values and digits of floats apart.
[[nodiscard]] std::string normal_candidate(std::string_view candidate);

}  // namespace bip::driver
