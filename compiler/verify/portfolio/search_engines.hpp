// Engines that visit states: with the engine's core one by one (search_bad_state.hpp), or all of them with the explorer
// on several threads. Complete for finite systems, given time and memory; they need the image's code.
#pragma once
#include "compiler/verify/portfolio/engine.hpp"

namespace bip::verify {

/// A short best-first search towards the candidate that the invariants leave open: about a second of work.
extern const Engine kFirstSearchEngine;
/// Random runs (random_runs.hpp), for what no first turn of the others has decided.
extern const Engine kRandomRunsEngine;
/// The exhaustive search. It stores a state in a tenth of the memory and visits many times as many per second.
extern const Engine kExhaustiveEngine;
/// Local deadlock: only the graph of all states decides it. The one engine for QuestionKind::NoLocalDeadlock.
extern const Engine kLocalDeadlockEngine;

/// Visits all states once more and lists them as a certificate's rows; an exhaustive search has met no bad one. Returns
/// an empty text if there are too many, or their data cannot be named. Cost: a sequential search.
[[nodiscard]] std::string list_reached_states(ProofContext& context, const CancellationToken& cancellation);

}  // namespace bip::verify
