// See mode_signals.hpp.
#include "compiler/verify/symbolic/mode_signals.hpp"

#include "compiler/system/system.hpp"
#include "compiler/verify/symbolic/cnf.hpp"
#include "compiler/verify/invariants/weighted_sum.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {
// "At most one" of more modes is left to the traps.
constexpr std::size_t kMaxPairs = 12;

// Its places and no others are marked, its known values hold.
Signal mode_signal(const Net& net, u32 mode, TransitionSystem& transition_system, const rt::Image& image) {
  const u32 atom = net.atom_of_mode[mode];
  const ModeClass& row = net.class_at(atom);
  const Mode& of = row.modes[mode - net.mode_base[atom]];
  BIP_ASSERT(mode >= net.mode_base[atom] && mode < net.mode_base[atom + 1], "mode {} of atom {}", mode, atom);
  const AtomType& type = net.system->atom_types[row.type];
  Aig& c = transition_system.aig;
  const std::vector<Signal>& marks = transition_system.marks[atom];
  Signal result = kTrue;
  std::vector<std::uint8_t> is_marked(marks.size(), 0);
  for (u32 place : of.places) {
    is_marked[place] = 1;
    result = c.make_and(result, marks[place]);
  }
  bool is_alone = of.places.size() == 1;
  is_alone = is_alone && transition_system.is_automaton[atom] != 0;
  for (std::size_t p = 0; p < marks.size() && !is_alone; ++p) {
    if (is_marked[p] == 0) result = c.make_and(result, negated(marks[p]));
  }
  for (std::size_t k = 0; k < type.variables.size(); ++k) {
    const Word& word = transition_system.words[image.atoms[atom].first_cell + k];
    if (row.followed[k] == 0 || !of.values[k].is_known || word.empty()) continue;
    // A string without row is "" in a system without strings.
    const bool is_nothing = type.variables[k].type == Type::String && of.values[k].value < 0;
    result = c.make_and(result, equal(c, word, word_of(is_nothing ? 0 : of.values[k].value)));
  }
  return result;
}

bool may_overlap(const ModeClass& row) {
  for (const Mode& mode : row.modes) {
    for (std::size_t k = 0; k < mode.values.size(); ++k) {
      if (row.followed[k] != 0 && !mode.values[k].is_known) return true;
    }
  }
  return false;
}

// The operands of a conjunction; of one that is an operand its own.
std::vector<Signal> conjuncts_of(const Aig& aig, Signal conjunction) {
  std::vector<Signal> result, todo{conjunction};
  std::vector<std::uint8_t> is_visited(aig.size(), 0);
  while (!todo.empty()) {
    const Signal signal = todo.back();
    todo.pop_back();
    const bool is_and = (signal & 1) == 0 && !aig.is_input(node_of(signal)) && node_of(signal) != 0;
    if (is_and && is_visited[node_of(signal)]++ == 0) {
      todo.push_back(aig.node(node_of(signal)).a);
      todo.push_back(aig.node(node_of(signal)).b);
    } else if (!is_and) {
      result.push_back(signal);
    }
  }
  return result;
}

}  // namespace

ModeSignals mode_signals(const Net& net, const Proof& proof, TransitionSystem& transition_system,
                         const rt::Image& image) {
  ModeSignals result;
  for (u32 atom = 0; atom + 1 < net.mode_base.size(); ++atom) {
    const bool overlaps = may_overlap(net.class_at(atom));
    std::vector<Signal> modes;
    for (u32 mode = net.mode_base[atom]; mode < net.mode_base[atom + 1]; ++mode) {
      result.modes.push_back(kFalse);
      if (proof.reachable[mode] == 0) continue;
      Signal signal = mode_signal(net, mode, transition_system, image);
      if (overlaps) {
        const Signal is_it = transition_system.aig.make_input();
        result.clauses.push_back({negated(is_it), signal});
        for (Signal other : modes) result.clauses.push_back({negated(other), negated(is_it)});
        signal = is_it;
      }
      modes.push_back(signal);
      result.modes.back() = signal;
    }
    BIP_ASSERT(result.modes.size() == net.mode_base[atom + 1], "{} modes up to atom {}", result.modes.size(), atom);
    result.clauses.push_back(std::move(modes));
  }
  return result;
}

std::vector<std::vector<Signal>> mode_clauses(const Net& net, const Proof& proof, TransitionSystem& transition_system,
                                              const rt::Image& image) {
  ModeSignals all = mode_signals(net, proof, transition_system, image);
  const std::vector<Signal>& signals = all.modes;
  std::vector<std::vector<Signal>>& clauses = all.clauses;
  for (const TokenInvariant& invariant : proof.invariants) {
    if (invariant.kind == InvariantKind::Sum) {
      WeightedSum sum;
      if (build_weighted_sum(net, invariant, proof.reachable, sum))
        clauses.push_back({weighted_sum_signal(sum, signals, transition_system.aig)});
      continue;
    }
    clauses.emplace_back();
    for (u32 mode : invariant.modes) {
      if (signals[mode] != kFalse) clauses.back().push_back(signals[mode]);
    }
    const std::vector<Signal> modes = clauses.back();
    if (invariant.kind != InvariantKind::OneToken || modes.size() > kMaxPairs) continue;
    for (std::size_t i = 0; i < modes.size(); ++i) {
      for (std::size_t j = i + 1; j < modes.size(); ++j) clauses.push_back({negated(modes[i]), negated(modes[j])});
    }
  }
  return std::move(all.clauses);
}

// One question per bound: each depends on few steps, while the question whether a step breaks any of them takes long
// with the rover's fourteen modules.
bool ranges_hold(const TransitionSystem& transition_system, const CancellationToken& cancellation) {
  if (transition_system.next_in_range == kTrue) return true;
  Solver solver(SolverStyle::Plain);
  Cnf cnf(transition_system.aig, solver);
  std::vector<Lit> chosen;
  // The clauses take as long as the answers.
  constexpr std::size_t kStepsBetweenLooks = 16;
  for (const SystemStep& step : transition_system.steps) {
    if (chosen.size() % kStepsBetweenLooks == 0 && cancellation.is_over()) return false;
    chosen.push_back(cnf.literal(step.chosen));
    solver.add({-chosen.back(), cnf.literal(step.fine)});
  }
  solver.add(chosen);
  add_at_most_one(solver, chosen);
  cnf.add_state(transition_system);
  for (const Signal bound : conjuncts_of(transition_system.aig, transition_system.next_in_range)) {
    const Lit holds = cnf.literal(bound);
    solver.assume(-holds);
    if (solver.solve(cancellation) != Answer::Unsatisfiable) return false;
    solver.add({holds});
  }
  return true;
}

}  // namespace bip::verify
