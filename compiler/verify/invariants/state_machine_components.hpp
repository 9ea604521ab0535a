// State-machine components: sets of modes that hold exactly one token, because every step takes at most one token out
// of the set and puts as many into it. Looked for in a candidate that marks two modes of such a set, which no trap can
// exclude.
//
// A SAT formula describes all components of the net (M. Hack: Analysis of Production Schemata by Petri Nets, 1972, for
// the notion; the encoding is by the connectors' trees and linear in the net). It is built on first use. What the
// solver finds is checked again by structure.
#pragma once
#include <memory>

#include "compiler/verify/invariants/place_invariant_checker.hpp"
#include "compiler/verify/solver/cancellation.hpp"
#include "compiler/verify/solver/solver.hpp"

namespace bip::verify {

/// Components that the callers ask for at most per candidate.
inline constexpr std::size_t kComponentBatch = 16;

class StateMachineComponentFinder {
 public:
  static constexpr std::size_t kMostModes = 40'000;
  StateMachineComponentFinder(const Net& net, const ModeReachability& reachable)
      : net_(net), reachable_(reachable), checker_(net, reachable) {}
  /// Returns at most `count` components of which the candidate (by mode: 1 if marked) marks at least two modes; none in
  /// nets of more than kMostModes modes.
  [[nodiscard]] std::vector<TokenInvariant> find(const std::vector<std::uint8_t>& marked, std::size_t count,
                                                 const CancellationToken& cancellation);

 private:
  /// What a choice below a node does to the number of tokens in the set: one more, one less, else nothing.
  struct Effect {
    Lit plus = 0, minus = 0;
    bool is_dead = false;  // there is no choice
  };
  void encode();
  void encode_two_witnesses();
  void encode_one_initial_token();
  [[nodiscard]] Effect encode_port(u32 port);
  [[nodiscard]] Effect encode_node(u32 node);
  [[nodiscard]] Effect encode_rendezvous(const std::vector<Effect>& children);

  const Net& net_;
  const ModeReachability& reachable_;
  PlaceInvariantChecker checker_;
  std::unique_ptr<Solver> solver_;
  std::vector<Lit> in_set_;                          // by mode; 0: not reachable
  std::vector<Lit> first_witness_, second_witness_;  // by mode: the two marked modes of the set
  std::vector<Effect> effects_;                      // by node
};

}  // namespace bip::verify
