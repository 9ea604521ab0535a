// Place invariants (P-invariants): weights of modes whose sum over the marked modes never changes. Looked for in a
// candidate whose sum differs from the initial one.
//
// A weighting is a place invariant if no step changes the sum: y · C = 0 for the incidence matrix C. Here the unknowns
// are not the weights but what each port changes the sum by (a port must change it alike in all its moves, so that a
// connector's interactions need not be listed); an atom's weights follow along any path from its initial modes. The
// equations: each cycle of an atom's modes changes nothing, and each step changes nothing (step_equations.hpp). They
// are solved once (sparse_system.hpp); each free unknown gives one invariant. A candidate that satisfies all of them
// satisfies the marking equation over the rationals, so no state-machine component excludes it either.
//
// Soundness does not rest on the arithmetic: what is found is checked again by structure (place_invariant_checker.hpp).
// Cost: as sparse as the system is; given up past a limit of work.
//
// K. Lautenbach: Linear Algebraic Techniques for Place/Transition Nets (1987). J. Esparza, S. Melzer: Verification of
// Safety Properties Using Integer Programming (2000), the marking equation and candidates.
#pragma once
#include "compiler/verify/invariants/place_invariant_checker.hpp"
#include "compiler/verify/invariants/sparse_system.hpp"

namespace bip::verify {

class PlaceInvariantFinder {
 public:
  PlaceInvariantFinder(const Net& net, const ModeReachability& reachable, const CancellationToken& cancellation)
      : net_(net),
        reachable_(reachable),
        checker_(net, reachable),
        port_changes_(net.graph.port_count(), net.graph.port_count(), cancellation) {}

  /// Returns invariants that the candidate (by mode: 1 if marked) breaks; none twice.
  [[nodiscard]] std::vector<TokenInvariant> find(const std::vector<std::uint8_t>& marked);
  /// Returns all that few ports change, whatever candidates say; find() does not return them again.
  [[nodiscard]] std::vector<TokenInvariant> find_small();
  /// Does the last candidate satisfy all place invariants, and so the marking equation?
  [[nodiscard]] bool satisfies_all() const { return satisfies_all_; }

 private:
  static constexpr std::size_t kMaxAtoms = 20000;  // of one invariant
  static constexpr std::size_t kFewPorts = 200;    // that change it, of a small one

  void solve();
  void add_cycle_equations(u32 atom, std::vector<SparseSystem::Row>& equations);
  [[nodiscard]] std::vector<u32> path_to(u32 mode) const;
  [[nodiscard]] std::vector<std::uint64_t> residuals_of(const std::vector<std::uint8_t>& marked) const;
  [[nodiscard]] bool invariant_of(u32 free_port, TokenInvariant& invariant);

  const Net& net_;
  const ModeReachability& reachable_;
  PlaceInvariantChecker checker_;
  SparseSystem port_changes_;  // its unknowns: by how much a port changes the sum
  bool is_solved_ = false, satisfies_all_ = false;
  std::vector<u32> parent_mode_, parent_port_;  // by mode: the last move of the path from an initial one, or kNoRow
  std::vector<std::uint8_t> is_returned_;       // by port: its invariant has been returned
  std::vector<std::int64_t> change_;            // by port, scratch
};

}  // namespace bip::verify
