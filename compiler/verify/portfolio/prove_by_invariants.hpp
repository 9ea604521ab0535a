// Deadlock-freedom by invariants: candidates from SAT, invariants from candidates, until there is no candidate or no
// invariant that excludes it.
//
// Free is a proof: every reachable stable state has a candidate step. Candidate is not a deadlock, only what the
// invariants leave open. Run-time errors end a run without being deadlocks; they are not looked at here.
#pragma once
#include <functional>

#include "compiler/verify/solver/cancellation.hpp"
#include "compiler/verify/net/net.hpp"
#include "compiler/verify/invariants/traps.hpp"

namespace bip::verify {

enum class ProofEnd : std::uint8_t {
  Free,       // proved
  Candidate,  // a state that no invariant excludes
  Stopped,    // the caller wants no more: it found out about the candidate
  TooLarge,   // an atom has too many local states
  Timeout
};
struct Proof {
  ProofEnd end = ProofEnd::Timeout;
  std::vector<TokenInvariant> invariants;
  std::vector<std::uint8_t> reachable;  // by mode, as far as the abstraction sees
  std::vector<u32> candidate;           // by atom: the mode
  std::uint64_t candidates = 0;         // models of the formula looked at
  std::size_t known = 0;                // of the invariants the first ones: those that came from elsewhere
};

/// QuestionKind about a candidate (by atom: the mode) that neither a trap nor a linear invariant excludes: true stops.
using StopAt = std::function<bool(const std::vector<u32>& candidate)>;

/// Which modes are reachable by structure, into `reachable` (fresh, forward) and the proof's.
void spread_from_initial(const Net& net, ModeReachability& reachable, Proof& proof);
/// Nothing but that, and of the invariants that are said to be `known` those that hold.
[[nodiscard]] Proof find_reachable_modes(const Net& net, const std::vector<TokenInvariant>& known = {});
/// Begins with those that are said to be `known` and hold.
[[nodiscard]] Proof prove_deadlock_freedom(const Net& net, const CancellationToken& cancellation,
                                           const StopAt& stop_at = {}, const std::vector<TokenInvariant>& known = {});
/// Leaves of a proof that is Free the invariants that it needs.
void minimize_invariants(const Net& net, const CancellationToken& cancellation, Proof& proof);

}  // namespace bip::verify
