// A run as the page reads it: the initial state, what each step did and changed, the candidates of each state, the end.
//
// {"timed": bool, "places": [text by atom], "data": [[text by variable] by atom], "names": [candidate],
//  "candidates": [{"rows": [row of names], "count": n} by state],
//  "steps": [[connector or -1, text, [[atom, port, transition or -1]], [[atom, places or null, [[variable, value]]]],
//             instant in ns, "file:line"]],
//  "end": {"story": text, "cycle": [atom]}}
#pragma once
#include <cstdint>

#include <nlohmann/json.hpp>

#include "compiler/system/system.hpp"
#include "runtime/debug/session.hpp"

namespace bip::view {

/// Takes the session from where it is, which is the initial state, to `steps` moves or to the end of the run, and
/// returns what happened. Cost: the steps, the candidates of each state (at most kMostCandidates of them), and what
/// changed.
[[nodiscard]] nlohmann::ordered_json record_run(const System& system, rt::DebugSession& session, std::uint64_t steps,
                                                std::uint64_t seed);

inline constexpr std::uint64_t kMostCandidates = 100;

}  // namespace bip::view
