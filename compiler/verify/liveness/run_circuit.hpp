// The circuit of a system with what its structure says of reachable states: made once, for all questions about its
// runs.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "compiler/verify/invariants/affine_bounds.hpp"
#include "compiler/verify/net/net.hpp"
#include "compiler/verify/portfolio/prove_by_invariants.hpp"
#include "compiler/verify/solver/cancellation.hpp"
#include "compiler/verify/symbolic/transition_system.hpp"
#include "runtime/include/bip/image.hpp"

namespace bip::verify {

/// Clauses that hold in every reachable state.
using StateClauses = std::vector<std::vector<Signal>>;

struct RunCircuit {
  TransitionSystem machine;
  StateClauses clauses;
  // Of which the clauses are.
  Net net;
  std::optional<Proof> proof;
  AffineInvariants affine;
  std::string problem;  // why it can prove nothing about runs; empty: it can
};

/// `system` and `image` are of one compilation. Modes and equations of the structure are searched for in a quarter of
/// the time, with the invariants that exclude deadlocks: what must happen mostly rests on them.
[[nodiscard]] RunCircuit make_run_circuit(const System& system, const rt::Image& image, std::size_t megabytes,
                                          const CancellationToken& cancellation);

/// Is the signal false in every reachable state and step? False, too, if the time is over.
[[nodiscard]] bool is_never(const RunCircuit& circuit, Signal bad, const CancellationToken& cancellation);

/// May a step end in a run-time error? True, too, if a sixteenth of the time does not suffice to exclude it.
[[nodiscard]] bool may_have_errors(const RunCircuit& circuit, const CancellationToken& cancellation);

}  // namespace bip::verify
