// The part of a machine that a question depends on, as clauses: a variable a node of the circuit (Tseitin).
#pragma once
#include "compiler/verify/machine.hpp"
#include "compiler/verify/net.hpp"
#include "compiler/verify/solver/solver.hpp"

namespace bip::verify {

/// Which bits and steps decide about some signals: everything below them, and below the next values of what is found.
struct Relevant {
  std::vector<std::uint8_t> bits, steps;
};
[[nodiscard]] Relevant find_relevant(const Machine& machine, const std::vector<Signal>& signals);
/// By node: does it depend on no bit that is not relevant?
[[nodiscard]] std::vector<std::uint8_t> nodes_of(const Machine& machine, const Relevant& relevant);

class Cnf {
 public:
  Cnf(const Circuit& circuit, Solver& solver);
  /// The literal of a signal; clauses for what is below are added when first asked for. The circuit may have grown.
  [[nodiscard]] Lit literal(Signal signal);
  /// One of these is true.
  void add(const std::vector<Signal>& clause);
  /// What is so in every state of the machine: each atom is in one place, data are in their ranges.
  void add_state(const Machine& machine);
  /// 0 if the node has no literal yet.
  [[nodiscard]] Lit known(Signal signal) const {
    if (node_of(signal) >= literals_.size()) return 0;
    const Lit here = literals_[node_of(signal)];
    return (signal & 1) != 0 ? -here : here;
  }

 private:
  const Circuit& circuit_;
  Solver& solver_;
  std::vector<Lit> literals_;  // by node
};

}  // namespace bip::verify
