// See refine_invariants.hpp.
#include "compiler/verify/invariants/refine_invariants.hpp"

#include "compiler/verify/symbolic/cnf.hpp"
#include "compiler/verify/invariants/place_invariants.hpp"
#include "compiler/verify/symbolic/mode_signals.hpp"
#include "compiler/verify/invariants/unsat_core.hpp"
#include "compiler/verify/invariants/state_machine_components.hpp"
#include "compiler/verify/invariants/weighted_sum.hpp"

namespace bip::verify {

namespace {

// "Bad, and what is known", which invariants are added to.
struct BadStateAbstraction {
  BadStateAbstraction(const Net& net_, TransitionSystem& machine_, const rt::Image& image, Signal bad,
                      const std::vector<std::vector<Signal>>& also, const Proof& proof)
      : net(net_),
        machine(machine_),
        reachable(proof.reachable),
        known(mode_signals(net_, proof, machine_, image)),
        cnf(machine_.circuit, solver) {
    for (const std::vector<Signal>& clause : known.clauses) cnf.add(clause);
    for (const std::vector<Signal>& clause : also) cnf.add(clause);
    cnf.add_state(machine);
    cnf.add({bad});
  }
  bool add(const TokenInvariant& invariant, Lit on = 0) {
    if (invariant.kind == InvariantKind::Sum) {
      WeightedSum sum;
      if (!build_weighted_sum(net, invariant, reachable, sum)) return false;
      cnf.add({weighted_sum_signal(sum, known.modes, machine.circuit)});
      return true;
    }
    std::vector<Lit> literals;
    for (u32 mode : invariant.modes) {
      if (known.modes[mode] != kFalse) literals.push_back(cnf.literal(known.modes[mode]));
    }
    if (on != 0) literals.push_back(-on);
    solver.add(literals);
    if (invariant.kind == InvariantKind::OneToken) add_at_most_one(solver, literals);
    return true;
  }
  [[nodiscard]] std::vector<std::uint8_t> marked() {
    std::vector<std::uint8_t> result;
    for (Signal mode : known.modes) result.push_back(mode != kFalse && solver.is_true(cnf.literal(mode)) ? 1 : 0);
    return result;
  }

  const Net& net;
  TransitionSystem& machine;
  const std::vector<std::uint8_t>& reachable;
  ModeSignals known;
  Solver solver;
  Cnf cnf;
};

}  // namespace

bool refine_invariants(const Net& net, TransitionSystem& machine, const rt::Image& image, Signal bad,
                       const std::vector<std::vector<Signal>>& known, const CancellationToken& cancellation,
                       Proof& proof) {
  if (bad == kFalse) return true;
  BadStateAbstraction question(net, machine, image, bad, known, proof);
  for (const TokenInvariant& invariant : proof.invariants) (void)question.add(invariant);
  const auto add_all = [&](std::vector<TokenInvariant> found) {
    std::size_t added = 0;
    for (TokenInvariant& invariant : found) {
      if (!question.add(invariant)) continue;
      proof.invariants.push_back(std::move(invariant));
      ++added;
    }
    return added;
  };

  ModeReachability reachable(net, Direction::Forward, nullptr);
  Proof again;
  spread_from_initial(net, reachable, again);
  TrapFinder traps(net, reachable);
  PlaceInvariantFinder sums(net, reachable, cancellation);
  StateMachineComponentFinder one_tokens(net, reachable);
  while (true) {
    const Answer answer = question.solver.solve(cancellation);
    if (answer != Answer::Satisfiable) return answer == Answer::Unsatisfiable;
    ++proof.candidates;
    const std::vector<std::uint8_t> marked = question.marked();
    std::size_t added = add_all(traps.find(marked));
    if (added == 0) {
      added = add_all(sums.find(traps, marked));
      if (added == 0 && !sums.satisfies_all())
        added = add_all(one_tokens.find(traps, marked, kComponentBatch, cancellation));
    }
    if (added == 0) return false;
  }
}

void minimize_invariants(const Net& net, TransitionSystem& machine, const rt::Image& image, Signal bad,
                         const std::vector<std::vector<Signal>>& known, const CancellationToken& cancellation,
                         Proof& proof) {
  BadStateAbstraction question(net, machine, image, bad, known, proof);
  std::vector<Lit> on;
  for (const TokenInvariant& invariant : proof.invariants) {
    on.push_back(invariant.kind == InvariantKind::Trap ? question.solver.new_variable() : 0);
    (void)question.add(invariant, on.back());
  }
  (void)minimize_by_unsat_core(question.solver, proof.invariants, on, cancellation);
}

}  // namespace bip::verify
