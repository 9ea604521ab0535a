// The loop: solve, largest trap, small traps, linear invariants, one-token invariants.
#include "compiler/verify/portfolio/prove_by_invariants.hpp"

#include <set>

#include "compiler/verify/net/net_encoding.hpp"
#include "compiler/verify/invariants/place_invariants.hpp"
#include "compiler/verify/invariants/state_machine_components.hpp"
#include "compiler/verify/invariants/token_invariant_checker.hpp"
#include "compiler/verify/invariants/traps.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {
// Candidates that the caller is asked about.
constexpr int kQuestions = 3;
}  // namespace

void spread_from_initial(const Net& net, ModeReachability& reachable, Proof& proof) {
  for (u32 atom = 0; atom + 1 < net.mode_base.size(); ++atom) {
    for (u32 mode : net.class_at(atom).initial) reachable.turn_on(net.mode_base[atom] + mode);
  }
  BIP_ASSERT(proof.reachable.empty(), "{} modes are reachable already", proof.reachable.size());
  reachable.run();
  for (u32 mode = 0; mode < net.mode_count(); ++mode) proof.reachable.push_back(reachable.is_on(mode) ? 1 : 0);
}

Proof find_reachable_modes(const Net& net, const std::vector<TokenInvariant>& given) {
  Proof proof;
  ModeReachability reachable(net, Direction::Forward, nullptr);
  spread_from_initial(net, reachable, proof);
  if (!given.empty()) proof.invariants = TokenInvariantChecker(net, reachable).those_that_hold(given);
  proof.reused = proof.invariants.size();
  return proof;
}

Proof prove_deadlock_freedom(const Net& net, const CancellationToken& cancellation, const StopAt& stop_at,
                             const std::vector<TokenInvariant>& given) {
  Proof proof;
  if (net.too_large_atom != kNoRow) {
    proof.end = ProofEnd::TooLarge;
    return proof;
  }
  ModeReachability reachable(net, Direction::Forward, nullptr);
  spread_from_initial(net, reachable, proof);

  Encoding encoding(net, reachable);
  TrapFinder traps(net, reachable);
  PlaceInvariantFinder sums(net, reachable, cancellation);
  StateMachineComponentFinder one_tokens(net, reachable);
  int questions = 0;
  const auto add_all = [&](std::vector<TokenInvariant> found) {
    std::size_t added = 0;
    for (TokenInvariant& invariant : found) {
      if (!encoding.add(invariant)) continue;
      proof.invariants.push_back(std::move(invariant));
      ++added;
    }
    return added;
  };
  if (!given.empty()) proof.reused = add_all(TokenInvariantChecker(net, reachable).those_that_hold(given));
  // Values that are told apart come and go by sums of their own: one by one they would need a candidate each.
  bool wants_small = !net.uses.of_atom.empty();
  const auto add_small = [&] {
    wants_small = false;
    std::vector<TokenInvariant> small = sums.find_small();
    const std::set<TokenInvariant> there(proof.invariants.begin(), proof.invariants.end());
    std::erase_if(small, [&](const TokenInvariant& invariant) { return there.contains(invariant); });
    return add_all(std::move(small));
  };
  if (wants_small && proof.reused == 0) (void)add_small();
  while (true) {
    const Answer answer = encoding.solve(cancellation);
    if (answer != Answer::Satisfiable) {
      proof.end = answer == Answer::Unsatisfiable ? ProofEnd::Free : ProofEnd::Timeout;
      return proof;
    }
    ++proof.candidates;
    if (wants_small && add_small() != 0) continue;
    const std::vector<std::uint8_t> marked = encoding.marked();
    std::size_t added = add_all(traps.find(marked));
    if (added == 0) added = add_all(sums.find(marked));
    if (added == 0) {
      proof.candidate.clear();
      for (u32 mode = 0; mode < net.mode_count(); ++mode) {
        if (marked[mode] != 0) proof.candidate.push_back(mode);
      }
      BIP_ASSERT(proof.candidate.size() + 1 == net.mode_base.size(), "a candidate of {} modes for {} atoms",
                 proof.candidate.size(), net.mode_base.size() - 1);
      if (stop_at && questions++ < kQuestions && stop_at(proof.candidate)) {
        proof.end = ProofEnd::Stopped;
        return proof;
      }
      // Half of what is left: where this does not help other engines are asked.
      if (!sums.satisfies_all())
        added = add_all(one_tokens.find(marked, kComponentBatch, cancellation.within(cancellation.seconds_left() / 2)));
    }
    if (added == 0) {
      proof.end = !cancellation.is_over() ? ProofEnd::Candidate : ProofEnd::Timeout;
      return proof;
    }
  }
}

void minimize_invariants(const Net& net, const CancellationToken& cancellation, Proof& proof) {
  BIP_ASSERT(proof.end == ProofEnd::Free, "only a proof can be reduced");
  Proof again;
  ModeReachability reachable(net, Direction::Forward, nullptr);
  spread_from_initial(net, reachable, again);
  Encoding encoding(net, reachable);
  std::vector<Lit> on;
  for (const TokenInvariant& invariant : proof.invariants) {
    on.push_back(invariant.kind != InvariantKind::OneToken ? encoding.new_switch() : 0);
    (void)encoding.add(invariant, on.back());
  }
  BIP_ASSERT(on.size() == proof.invariants.size() && again.reachable == proof.reachable,
             "{} switches of {} invariants, or other modes", on.size(), proof.invariants.size());
  (void)encoding.minimize_invariants(proof.invariants, on, cancellation);
}

}  // namespace bip::verify
