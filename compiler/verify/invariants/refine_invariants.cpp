// See refine_invariants.hpp.
#include "compiler/verify/invariants/refine_invariants.hpp"

#include "compiler/base/log.hpp"
#include "compiler/verify/invariants/place_invariants.hpp"
#include "compiler/verify/invariants/state_machine_components.hpp"
#include "compiler/verify/invariants/traps.hpp"
#include "compiler/verify/invariants/unsat_core.hpp"
#include "compiler/verify/invariants/weighted_sum.hpp"
#include "compiler/verify/symbolic/cnf.hpp"
#include "compiler/verify/symbolic/mode_signals.hpp"

namespace bip::verify {

namespace {

/// The bad states that the invariants so far allow, as clauses.
class BadStateAbstraction {
 public:
  BadStateAbstraction(const Net& net, TransitionSystem& system, const rt::Image& image, Signal bad,
                      const std::vector<std::vector<Signal>>& assumed, const Proof& proof)
      : net_(net),
        system_(system),
        reachable_(proof.reachable),
        modes_(mode_signals(net, proof, system, image)),
        cnf_(system.aig, solver_) {
    for (const std::vector<Signal>& clause : modes_.clauses) cnf_.add(clause);
    for (const std::vector<Signal>& clause : assumed) cnf_.add(clause);
    cnf_.add_state(system);
    cnf_.add({bad});
  }
  /// False: a place invariant that is too large for clauses. A trap with a switch counts only where that is assumed.
  bool add(const TokenInvariant& invariant, Lit activation = 0) {
    if (invariant.kind == InvariantKind::Sum) {
      WeightedSum sum;
      if (!build_weighted_sum(net_, invariant, reachable_, sum)) return false;
      cnf_.add({weighted_sum_signal(sum, modes_.modes, system_.aig)});
      return true;
    }
    std::vector<Lit> literals;
    for (u32 mode : invariant.modes) {
      if (modes_.modes[mode] != kFalse) literals.push_back(cnf_.literal(modes_.modes[mode]));
    }
    if (activation != 0) literals.push_back(-activation);
    solver_.add(literals);
    if (invariant.kind == InvariantKind::OneToken) add_at_most_one(solver_, literals);
    return true;
  }
  [[nodiscard]] Solver& solver() { return solver_; }
  /// By mode: 1 if marked in the candidate.
  [[nodiscard]] std::vector<std::uint8_t> marked() {
    std::vector<std::uint8_t> result;
    for (Signal mode : modes_.modes) result.push_back(mode != kFalse && solver_.is_true(cnf_.literal(mode)) ? 1 : 0);
    return result;
  }

 private:
  const Net& net_;
  TransitionSystem& system_;
  const std::vector<std::uint8_t>& reachable_;
  ModeSignals modes_;
  Solver solver_;
  Cnf cnf_;
};

}  // namespace

bool refine_invariants(const Net& net, TransitionSystem& system, const rt::Image& image, Signal bad,
                       const std::vector<std::vector<Signal>>& assumed, const CancellationToken& cancellation,
                       Proof& proof) {
  if (bad == kFalse) return true;
  BadStateAbstraction abstraction(net, system, image, bad, assumed, proof);
  for (const TokenInvariant& invariant : proof.invariants) (void)abstraction.add(invariant);
  const auto add_all = [&](std::vector<TokenInvariant> found) {
    std::size_t added = 0;
    for (TokenInvariant& invariant : found) {
      if (!abstraction.add(invariant)) continue;
      proof.invariants.push_back(std::move(invariant));
      ++added;
    }
    return added;
  };

  ModeReachability reachable(net, Direction::Forward, nullptr);
  Proof ignored;
  spread_from_initial(net, reachable, ignored);
  TrapFinder traps(net, reachable);
  PlaceInvariantFinder place_invariants(net, reachable, cancellation);
  StateMachineComponentFinder components(net, reachable);
  while (true) {
    const Answer answer = abstraction.solver().solve(cancellation);
    if (answer != Answer::Satisfiable) {
      BIP_LOG(Portfolio, 1, "structural refinement: {} invariants, {}", proof.invariants.size(),
              answer == Answer::Unsatisfiable ? "no bad state is left" : "the time is over");
      return answer == Answer::Unsatisfiable;
    }
    ++proof.candidates;
    // The cheapest kind that excludes the candidate refines. What satisfies the marking equation satisfies all
    // components, too.
    const std::vector<std::uint8_t> marked = abstraction.marked();
    std::size_t added = add_all(traps.find(marked));
    if (added == 0) {
      added = add_all(place_invariants.find(marked));
      if (added == 0 && !place_invariants.satisfies_all())
        added = add_all(components.find(marked, kComponentBatch, cancellation));
    }
    if (added == 0) return false;
  }
}

void minimize_invariants(const Net& net, TransitionSystem& system, const rt::Image& image, Signal bad,
                         const std::vector<std::vector<Signal>>& assumed, const CancellationToken& cancellation,
                         Proof& proof) {
  BadStateAbstraction abstraction(net, system, image, bad, assumed, proof);
  std::vector<Lit> activations;
  for (const TokenInvariant& invariant : proof.invariants) {
    activations.push_back(invariant.kind == InvariantKind::Trap ? abstraction.solver().new_variable() : 0);
    (void)abstraction.add(invariant, activations.back());
  }
  (void)minimize_by_unsat_core(abstraction.solver(), proof.invariants, activations, cancellation);
}

}  // namespace bip::verify
