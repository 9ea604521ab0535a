// A run as the page reads it: the initial state, what each step did and changed, the candidates of each state, the end.
//
// {"timed": bool, "places": [text by atom], "data": [[text by variable] by atom], "names": [candidate],
//  "states": [{"rows": [row of names], "count": n}], "candidates": [row of states by state],
//  "rows": [[connector or -1, text, [[atom, port, transition or -1]], [[atom, places or null, [[variable, value]]]],
//           0, "file:line"]], "steps": [row of rows],
//  "instants": [ns by step], "sets": [[step, [[atom, clock, value, since, speed]]]],
//  "clock_names": [[name, unit] by clock, by type], "clocks": [[value, since, speed] by clock, by atom],
//  "is_cut": true if the run goes on, "end": {"story": text, "cycle": [atom]}}
// Of a live run (compiler/live) steps and candidates are whole rows, with the instant, and with what clocks were set to
// behind the line.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime/debug/session.hpp"

namespace bip {
struct System;
}

namespace bip::view {

/// The parts of the record, for a run that is made while it is watched. Refers to both, which must outlive it.
class RunRecorder {
 public:
  using Json = nlohmann::ordered_json;
  RunRecorder(const System& system, rt::DebugSession& session);

  /// Whether the model has time, places and data of the session's state.
  [[nodiscard]] Json state();
  /// The candidates of the session's state.
  [[nodiscard]] Json candidates();
  /// What becomes a candidate when time passes: [[text, instants, the first of them in ns]].
  [[nodiscard]] Json later();
  /// What the last move did.
  [[nodiscard]] Json step(const rt::LastMove& move);
  /// How the run ended in the session's state, which `halt` led to; null: it did not.
  [[nodiscard]] Json end(rt::Halt halt, std::uint64_t seed);
  /// What the rows of candidates() mean; it grows only.
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }

 private:
  [[nodiscard]] std::uint32_t shown_variables(rt::u32 atom) const;
  [[nodiscard]] std::string value(rt::u32 atom, std::uint32_t variable) const;
  [[nodiscard]] std::size_t row_of(const std::string& name);
  [[nodiscard]] Json clock(rt::u32 atom, rt::u32 row) const;
  [[nodiscard]] Json set_clocks(const rt::LastMove& move) const;
  [[nodiscard]] std::int64_t transition(const rt::MovePart& part) const;

  const System& system_;
  rt::DebugSession& session_;
  std::map<std::string, std::size_t> rows_;
  std::vector<std::string> names_;
};

/// Takes the session from where it is, which is the initial state, to `steps` moves or to the end of the run, and
/// returns what happened; less if the record became larger than kMostRecord. Cost: the steps, the candidates of each
/// state (at most kMostCandidates of them), and what changed. Size: equal steps and states are stored once.
[[nodiscard]] nlohmann::ordered_json record_run(const System& system, rt::DebugSession& session, std::uint64_t steps,
                                                std::uint64_t seed);

inline constexpr std::uint64_t kMostCandidates = 100;
inline constexpr std::size_t kMostRecord = std::size_t{64} << 20;

}  // namespace bip::view
