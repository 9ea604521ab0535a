// Linear invariants: weights of modes of which the sum over all atoms never changes (place invariants of the marking
// equation). Looked for in a candidate whose sum is not the initial state's.
//
// A step changes the sum by what its ports change it, so a port of a connector must change it by the same in all its
// moves. The unknowns are these changes, one a port; the weights of an atom's modes follow along any way to them.
// Equations: one for each way round in an atom, one or more for each node of the connectors' trees. They are solved
// once (sparse_system.hpp); each free unknown gives one invariant. A candidate that breaks none of these satisfies the
// marking equation, and then no one-token invariant excludes it either. Nothing rests on the arithmetic: what is found
// is checked again by structure. Cost: as sparse as the system is; given up past a limit of work. After J. Esparza, S.
// Melzer (2000); K. Lautenbach: Linear Algebraic Techniques for Place/Transition Nets (1987).
#pragma once
#include "compiler/verify/invariants/sparse_system.hpp"
#include "compiler/verify/invariants/traps.hpp"

namespace bip::verify {

class PlaceInvariantFinder {
 public:
  PlaceInvariantFinder(const Net& net, const ModeReachability& reachable, const CancellationToken& cancellation)
      : net_(net), reachable_(reachable), system_(net.port_count(), net.port_count(), cancellation) {}

  /// Invariants that the candidate (by mode: 1 if marked) breaks; none twice.
  [[nodiscard]] std::vector<TokenInvariant> find(TrapFinder& checker, const std::vector<std::uint8_t>& marked);
  /// All that few ports change, whatever candidates say; find() does not give them again.
  [[nodiscard]] std::vector<TokenInvariant> find_small(TrapFinder& checker);
  /// The last candidate breaks no linear invariant at all, so no one-token invariant either.
  [[nodiscard]] bool satisfies_all() const { return satisfies_all_; }

 private:
  static constexpr std::size_t kMaxAtoms = 20000;  // of one invariant
  static constexpr std::size_t kFewPorts = 200;    // that change it, of a small one

  void solve();
  void walk_atom(u32 atom, std::vector<SparseSystem::Row>& equations);
  [[nodiscard]] bool solution(u32 port, TokenInvariant& invariant);

  const Net& net_;
  const ModeReachability& reachable_;
  SparseSystem system_;  // its unknowns: what a port changes
  bool is_solved_ = false, satisfies_all_ = false;
  std::vector<u32> parent_mode_, parent_port_;  // by mode: the way from an initial one; kNoRow: it is one
  std::vector<std::uint8_t> is_used_;           // by port: its invariant has been given
  std::vector<std::int64_t> change_;            // by port, scratch
};

}  // namespace bip::verify
