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

// Named, for InvariantRefiner::Parts has a member of it.
namespace refinement {

/// The bad states that the invariants so far allow, as clauses.
class BadStateAbstraction {
 public:
  /// `bad`: kTrue if it is assumed by each question.
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
    if (bad != kTrue) cnf_.add({bad});
  }
  [[nodiscard]] Lit literal(Signal signal) { return cnf_.literal(signal); }
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

/// Adds invariants to a proof until they exclude what is asked for.
class Refinement {
 public:
  Refinement(const Net& net, TransitionSystem& system, const rt::Image& image, Signal bad,
             const std::vector<std::vector<Signal>>& assumed, const CancellationToken& cancellation, Proof& proof)
      : cancellation_(cancellation),
        proof_(proof),
        abstraction_(net, system, image, bad, assumed, proof),
        reachable_(net, Direction::Forward, nullptr),
        traps_(net, spread(net, reachable_)),
        place_invariants_(net, reachable_, cancellation),
        components_(net, reachable_) {
    for (const TokenInvariant& invariant : proof.invariants) (void)abstraction_.add(invariant);
  }

  /// `states`: kTrue: the bad ones.
  bool run(Signal states) {
    while (true) {
      if (states != kTrue) abstraction_.solver().assume(abstraction_.literal(states));
      const Answer answer = abstraction_.solver().solve(cancellation_);
      if (answer != Answer::Satisfiable) {
        BIP_LOG(Portfolio, 1, "structural refinement: {} invariants, {}", proof_.invariants.size(),
                answer == Answer::Unsatisfiable ? "no bad state is left" : "the time is over");
        return answer == Answer::Unsatisfiable;
      }
      ++proof_.candidates;
      // The cheapest kind that excludes the candidate refines. What satisfies the marking equation satisfies all
      // components, too.
      const std::vector<std::uint8_t> marked = abstraction_.marked();
      std::size_t added = add_all(traps_.find(marked));
      if (added == 0) {
        added = add_all(place_invariants_.find(marked));
        if (added == 0 && !place_invariants_.satisfies_all())
          added = add_all(components_.find(marked, kComponentBatch, cancellation_));
      }
      if (added == 0) return false;
    }
  }

 private:
  static const ModeReachability& spread(const Net& net, ModeReachability& reachable) {
    Proof ignored;
    spread_from_initial(net, reachable, ignored);
    return reachable;
  }
  std::size_t add_all(std::vector<TokenInvariant> found) {
    std::size_t added = 0;
    for (TokenInvariant& invariant : found) {
      if (!abstraction_.add(invariant)) continue;
      proof_.invariants.push_back(std::move(invariant));
      ++added;
    }
    return added;
  }

  CancellationToken cancellation_;
  Proof& proof_;
  BadStateAbstraction abstraction_;
  ModeReachability reachable_;
  TrapFinder traps_;
  PlaceInvariantFinder place_invariants_;
  StateMachineComponentFinder components_;
};

}  // namespace refinement

using refinement::BadStateAbstraction;
using refinement::Refinement;

bool refine_invariants(const Net& net, TransitionSystem& system, const rt::Image& image, Signal bad,
                       const std::vector<std::vector<Signal>>& assumed, const CancellationToken& cancellation,
                       Proof& proof) {
  if (bad == kFalse) return true;
  return Refinement(net, system, image, bad, assumed, cancellation, proof).run(kTrue);
}

struct InvariantRefiner::Parts {
  Refinement refinement;
};
InvariantRefiner::InvariantRefiner(const Net& net, TransitionSystem& system, const rt::Image& image,
                                   const CancellationToken& cancellation, Proof& proof)
    : parts_(new Parts{Refinement(net, system, image, kTrue, {}, cancellation, proof)}) {}
InvariantRefiner::~InvariantRefiner() = default;
bool InvariantRefiner::exclude(Signal states) { return states == kFalse || parts_->refinement.run(states); }

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
