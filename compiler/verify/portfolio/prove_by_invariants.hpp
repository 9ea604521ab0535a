// Deadlock-freedom by invariants: candidates from SAT, invariants from candidates, until there is no candidate or no
// invariant that excludes it.
//
// Free is a proof: every reachable stable state has an enabled interaction. Candidate is not a deadlock, only a state
// that the invariants do not exclude. Run-time errors end a run without being deadlocks and are not considered here.
#pragma once
#include <functional>

#include "compiler/verify/solver/cancellation.hpp"
#include "compiler/verify/net/net.hpp"
#include "compiler/verify/invariants/token_invariant.hpp"
#include "compiler/verify/net/mode_reachability.hpp"

namespace bip::verify {

enum class ProofEnd : std::uint8_t {
  Free,       // proved
  Candidate,  // a state that no invariant excludes
  Stopped,    // StopAt said so
  TooLarge,   // an atom has too many local states
  Timeout
};
struct Proof {
  ProofEnd end = ProofEnd::Timeout;
  std::vector<TokenInvariant> invariants;
  std::vector<std::uint8_t> reachable;  // by mode, as far as the abstraction sees
  std::vector<u32> candidate;           // by atom: the mode
  std::uint64_t candidates = 0;         // models of the formula that were excluded or left open
  std::size_t reused = 0;               // how many of the invariants, the first ones, came from elsewhere
};

/// Is called with a candidate (by atom: its mode) that neither a trap nor a place invariant excludes; true ends the
/// proof.
using StopAt = std::function<bool(const std::vector<u32>& candidate)>;

/// Computes the modes that structure lets be reached, into `reachable` (fresh, forward) and into the proof. Cost:
/// linear in the net.
void spread_from_initial(const Net& net, ModeReachability& reachable, Proof& proof);
/// Computes only the reachable modes, and which of the invariants `given` from elsewhere hold. Cost: linear in the net,
/// a pass for each invariant.
[[nodiscard]] Proof find_reachable_modes(const Net& net, const std::vector<TokenInvariant>& given = {});
/// Proves deadlock-freedom, or returns a candidate that no invariant excludes. Begins with those invariants that are
/// `given` from elsewhere and hold. Sound but incomplete: failure implies nothing. Cost: a call of the solver and
/// linear passes over the net for each candidate, until `cancellation` is over.
[[nodiscard]] Proof prove_deadlock_freedom(const Net& net, const CancellationToken& cancellation,
                                           const StopAt& stop_at = {}, const std::vector<TokenInvariant>& given = {});
/// Reduces the traps of a proof that is Free to those in the core of the contradiction. Leaves all of them if the
/// solver has no answer before `cancellation` is over. Cost: one call of the solver.
void minimize_invariants(const Net& net, const CancellationToken& cancellation, Proof& proof);

}  // namespace bip::verify
