// Linear invariants: weights of modes of which the sum over all atoms never changes (place invariants of the marking equation).
// Looked for in a candidate whose sum is not the initial state's.
//
// A step changes the sum by what its ports change it, so a port of a connector must change it by the same in all its moves. The
// unknowns are these changes, one a port; the weights of an atom's modes follow along any way to them. Equations: one for each way
// round in an atom, one or more for each node of the connectors' trees. They are solved once, over the integers, sparsely
// (Gauss-Jordan); each free unknown gives one invariant. A candidate that breaks none of these satisfies the marking equation, and then
// no one-token invariant excludes it either. Nothing rests on the arithmetic: what is found is checked again by structure.
// Cost: as sparse as the system is; given up past kMaxWork. After J. Esparza, S. Melzer (2000); K. Lautenbach: Linear Algebraic
// Techniques for Place/Transition Nets (1987).
#pragma once
#include "compiler/verify/traps.hpp"

namespace bip::verify {

class LinearFinder {
 public:
  LinearFinder(const Net& net, const Spread& reachable) : net_(net), reachable_(reachable) {}

  /// Invariants that the candidate (by mode: 1 if marked) breaks; none twice.
  [[nodiscard]] std::vector<TokenInvariant> find(TrapFinder& checker, const std::vector<std::uint8_t>& marked);
  /// All that few ports change, whatever candidates say; find() does not give them again.
  [[nodiscard]] std::vector<TokenInvariant> find_small(TrapFinder& checker);
  /// The last candidate breaks no linear invariant at all, so no one-token invariant either.
  [[nodiscard]] bool satisfies_all() const { return satisfies_all_; }

 private:
  static constexpr std::uint64_t kMaxWork = 200'000'000;
  static constexpr std::int64_t kMaxNumber = 1 << 24;
  static constexpr std::size_t kMaxAtoms = 20000;  // of one invariant
  static constexpr std::size_t kFewPorts = 200;    // that change it, of a small one

  struct Term {
    u32 port = 0;
    std::int64_t factor = 0;
  };
  // Sorted by port, no factor 0: the sum is 0.
  using Row = std::vector<Term>;

  void solve();
  void walk_atom(u32 atom, std::vector<Row>& equations);
  void add_nodes(std::vector<Row>& equations);
  void add_equation(Row row);
  [[nodiscard]] Row combined(const Row& a, std::int64_t factor_a, const Row& b, std::int64_t factor_b);
  [[nodiscard]] static std::int64_t factor_of(const Row& row, u32 port);
  void eliminate(Row& row, u32 port, const Row& by);
  [[nodiscard]] bool solution(u32 port, TokenInvariant& invariant);

  const Net& net_;
  const Spread& reachable_;
  bool is_solved_ = false, is_given_up_ = false, satisfies_all_ = false;
  std::uint64_t work_ = 0;
  std::vector<u32> parent_mode_, parent_port_;  // by mode: the way from an initial one; kNoRow: it is one
  std::vector<Row> rows_;                       // each has one port that is in no other: what it gives
  std::vector<u32> row_of_;                     // by port: the row that gives it, or kNoRow
  std::vector<std::vector<u32>> rows_with_;     // by port: where it may stand on the other side
  std::vector<std::uint8_t> is_used_;           // by port: its invariant has been given
  std::vector<std::int64_t> change_;            // by port, scratch
};

}  // namespace bip::verify
