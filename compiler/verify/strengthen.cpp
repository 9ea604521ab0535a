// See strengthen.hpp.
#include "compiler/verify/strengthen.hpp"

#include "compiler/verify/cnf.hpp"
#include "compiler/verify/linear.hpp"
#include "compiler/verify/mode_signals.hpp"
#include "compiler/verify/one_token.hpp"
#include "compiler/verify/weighted_sum.hpp"

namespace bip::verify {

namespace {
constexpr std::size_t kOneTokenBatch = 16;
}

bool strengthen(const Net& net, Machine& machine, const rt::Image& image, Signal bad, Clock::time_point end, Proof& proof) {
  if (bad == kFalse) return true;
  const ModeSignals all = mode_signals(net, proof, machine, image);
  const std::vector<Signal>& modes = all.modes;
  Solver solver;
  Cnf cnf(machine.circuit, solver);
  const auto add = [&](const std::vector<Signal>& clause) {
    std::vector<Lit> literals;
    for (Signal s : clause) literals.push_back(cnf.literal(s));
    solver.add(literals);
  };
  for (const std::vector<Signal>& clause : all.clauses) add(clause);
  for (Signal inside : machine.in_range) add({inside});
  for (const std::vector<u32>& group : machine.exactly_one) {
    std::vector<Lit> places;
    for (u32 row : group) places.push_back(cnf.literal(machine.bits[row].now));
    solver.add(places);
    add_at_most_one(solver, places);
  }
  add({bad});

  const auto add_token = [&](const TokenInvariant& invariant) {
    if (invariant.kind == InvariantKind::Sum) {
      WeightedSum sum;
      if (!build_weighted_sum(net, invariant, proof.reachable, sum)) return false;
      add({weighted_sum_signal(sum, modes, machine.circuit)});
      return true;
    }
    std::vector<Lit> literals;
    for (u32 mode : invariant.modes) {
      if (modes[mode] != kFalse) literals.push_back(cnf.literal(modes[mode]));
    }
    solver.add(literals);
    if (invariant.kind == InvariantKind::OneToken) add_at_most_one(solver, literals);
    return true;
  };
  for (const TokenInvariant& invariant : proof.invariants) (void)add_token(invariant);
  const auto add_all = [&](std::vector<TokenInvariant> found) {
    std::size_t added = 0;
    for (TokenInvariant& invariant : found) {
      if (!add_token(invariant)) continue;
      proof.invariants.push_back(std::move(invariant));
      ++added;
    }
    return added;
  };

  Spread reachable(net, Direction::Forward, nullptr);
  Proof again;
  spread_from_initial(net, reachable, again);
  TrapFinder traps(net, reachable);
  LinearFinder sums(net, reachable);
  OneTokenFinder one_tokens(net, reachable);
  while (true) {
    const Answer answer = solver.solve(seconds_until(end));
    if (answer != Answer::Satisfiable) return answer == Answer::Unsatisfiable;
    ++proof.candidates;
    std::vector<std::uint8_t> marked(net.mode_count(), 0);
    for (u32 mode = 0; mode < net.mode_count(); ++mode) marked[mode] = modes[mode] != kFalse && solver.is_true(cnf.literal(modes[mode])) ? 1 : 0;
    std::size_t added = add_all(traps.find(marked));
    if (added == 0) {
      added = add_all(sums.find(traps, marked));
      if (added == 0 && !sums.satisfies_all()) added = add_all(one_tokens.find(traps, marked, kOneTokenBatch, seconds_until(end)));
    }
    if (added == 0) return false;
  }
}

}  // namespace bip::verify
