// The part of a machine that a question depends on, as clauses: a variable a node of the circuit (Tseitin).
#pragma once
#include "compiler/verify/symbolic/transition_system.hpp"
#include "compiler/verify/net/net.hpp"
#include "compiler/verify/solver/solver.hpp"

namespace bip::verify {

/// Which bits and steps decide about some signals: everything below them, and below the next values of what is found.
struct ConeOfInfluence {
  std::vector<std::uint8_t> bits, steps;
};
[[nodiscard]] ConeOfInfluence cone_of_influence(const TransitionSystem& machine, const std::vector<Signal>& signals);
/// By node: does it depend on no bit that is not relevant?
[[nodiscard]] std::vector<std::uint8_t> nodes_in_cone(const TransitionSystem& machine, const ConeOfInfluence& relevant);

class Cnf {
 public:
  Cnf(const Aig& circuit, Solver& solver);
  /// The literal of a signal; clauses for what is below are added when first asked for. The circuit may have grown.
  [[nodiscard]] Lit literal(Signal signal);
  /// One of these is true.
  void add(const std::vector<Signal>& clause);
  /// What is so in every state of the machine: each atom is in one place, data are in their ranges.
  void add_state(const TransitionSystem& machine);
  /// 0 if the node has no literal yet.
  [[nodiscard]] Lit known(Signal signal) const {
    if (node_of(signal) >= literals_.size()) return 0;
    const Lit here = literals_[node_of(signal)];
    return (signal & 1) != 0 ? -here : here;
  }

 private:
  const Aig& circuit_;
  Solver& solver_;
  std::vector<Lit> literals_;  // by node
};

}  // namespace bip::verify
