// Decides a property of runs with the engines that there are for it, in turns: the graph of all reachable states
// (liveness.hpp), which also finds violations, neighbourhoods (neighbourhood_runs.hpp), and k-liveness on the circuit
// (k_liveness.hpp). The table in decide_runs.cpp says who is tried when, with how much of the time.
#pragma once
#include <optional>
#include <string>

#include "compiler/verify/liveness/k_liveness.hpp"
#include "compiler/verify/liveness/liveness.hpp"
#include "compiler/verify/liveness/neighbourhood_runs.hpp"
#include "compiler/verify/portfolio/proof_context.hpp"

namespace bip::verify {

struct RunsDecision {
  Outcome outcome = Outcome::Unknown;
  std::string reason;                                   // Unknown
  LivenessResult on_graph;                              // of its last turn
  std::optional<KLivenessProof> proof;                  // Holds by k-liveness
  std::optional<NeighbourhoodProof> by_neighbourhoods;  // Holds by these
};

/// `system` and `image` are of one compilation, without time and without a fault in the initialization. Searchable: the
/// image has its code, and the system calls no C++ and draws no random numbers.
[[nodiscard]] RunsDecision decide_runs(const Formula& formula, const System& system, const rt::Image& image,
                                       StateAccess access, const LivenessOptions& options);

/// Why a model with C++ that decides, or with random numbers, has no graph of states.
[[nodiscard]] std::string reason_without_graph(const System& system);

}  // namespace bip::verify
