// CNF of the part of an AIG that a question depends on: one variable per node (G. Tseitin: On the Complexity of
// Derivation in Propositional Calculus, 1968). And the cone of influence of signals (E. Clarke, O. Grumberg, D. Peled:
// Model Checking, 1999, section 13.1).
#pragma once
#include "compiler/verify/symbolic/transition_system.hpp"
#include "compiler/verify/net/net.hpp"
#include "compiler/verify/solver/solver.hpp"

namespace bip::verify {

/// Which state bits and steps can influence some signals.
struct ConeOfInfluence {
  std::vector<std::uint8_t> bits, steps;
};
/// Computes the least set that contains the support of the signals and the support of next(bit) for each of its bits.
/// Places of one automaton are in the cone together. `followed`, by bit: the others count as inputs, and are not in the
/// cone; empty: all are followed. Linear in the AIG.
[[nodiscard]] ConeOfInfluence cone_of_influence(const TransitionSystem& system, const std::vector<Signal>& signals,
                                                const std::vector<std::uint8_t>& followed = {});
/// Returns the atoms whose state bits are in the support of a signal, ascending. Linear in the AIG.
[[nodiscard]] std::vector<u32> atoms_below(const TransitionSystem& system, Signal signal);
/// By node: does its support lie in the cone?
[[nodiscard]] std::vector<std::uint8_t> nodes_in_cone(const TransitionSystem& system, const ConeOfInfluence& cone);

/// Adds to a solver the clauses of the nodes that it is asked for. Keeps references to both; the AIG may grow.
class Cnf {
 public:
  Cnf(const Aig& aig, Solver& solver);
  /// Returns the literal of a signal; encodes the nodes below it on first use.
  [[nodiscard]] Lit literal(Signal signal);
  /// Adds a clause.
  void add(const std::vector<Signal>& clause);
  /// Fixes an input to false: nodes that it decides are no variables, and need no clauses. Requires that no signal that
  /// depends on it is encoded.
  void fix_false(Signal input);
  /// Adds what holds in every state: each automaton is in exactly one place, data are in their ranges.
  void add_state(const TransitionSystem& system);
  /// Adds that the state is as add_state() says and satisfies the invariants, and that at most one step is chosen.
  /// Returns a literal that implies that one is, and that it ends in no fault.
  [[nodiscard]] Lit add_step(const TransitionSystem& system, const std::vector<std::vector<Signal>>& invariants);
  /// The same, with only the steps of the rows [begin, end); the inputs that choose the others become false. Requires
  /// that nothing is encoded.
  [[nodiscard]] Lit add_step(const TransitionSystem& system, const std::vector<std::vector<Signal>>& invariants,
                             std::size_t begin, std::size_t end);
  /// Returns the literal of a signal that is encoded already, else 0.
  [[nodiscard]] Lit encoded(Signal signal) const {
    if (node_of(signal) >= literals_.size()) return 0;
    const Lit variable = literals_[node_of(signal)];
    return (signal & 1) != 0 ? -variable : variable;
  }

 private:
  // The constant that a literal is, as far as the circuit shows it.
  [[nodiscard]] bool is_false(Lit literal) const { return literal == literals_[0]; }
  [[nodiscard]] bool is_true(Lit literal) const { return literal == -literals_[0]; }

  const Aig& aig_;
  Solver& solver_;
  std::vector<Lit> literals_;  // by node; 0: not encoded
};

}  // namespace bip::verify
