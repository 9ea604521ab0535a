// Homogeneous linear equations over the integers, solved sparsely (Gauss-Jordan): each row gives one unknown by the
// free ones.
//
// Who asks is told small integers or nothing: rows are kept without common divisors, and the work is given up past
// kMaxWork, past kMaxNumber, or when the time is over. Cost: as sparse as the equations are.
#pragma once
#include <cstdint>
#include <vector>

#include "compiler/verify/solver/cancellation.hpp"

namespace bip::verify {

class SparseSystem {
 public:
  static constexpr std::uint64_t kMaxWork = 200'000'000;
  static constexpr std::int64_t kMaxNumber = 1 << 24;
  static constexpr std::uint32_t kNone = 0xffffffffu;
  struct Term {
    std::uint32_t unknown = 0;
    std::int64_t factor = 0;
  };
  /// Sorted by unknown, each once, no factor 0: the sum is 0.
  using Row = std::vector<Term>;

  /// The terms in any order, unknowns more than once. Not divided by anything.
  [[nodiscard]] static Row row_of_terms(std::vector<Term> terms);

  /// Unknowns from `first_reluctant` on are given by others only where nothing else is in a row.
  SparseSystem(std::uint32_t unknowns, std::uint32_t first_reluctant, const CancellationToken& cancellation)
      : first_reluctant_(first_reluctant),
        cancellation_(cancellation),
        row_of_(unknowns, kNone),
        rows_with_(unknowns) {}

  /// In the order that fills least: short ones first.
  void solve(std::vector<Row> equations);
  [[nodiscard]] bool is_given_up() const { return is_given_up_; }
  void give_up() { is_given_up_ = true; }
  /// Work that was done elsewhere for this system. False: it is too much.
  bool spend(std::uint64_t work);

  [[nodiscard]] bool is_free(std::uint32_t unknown) const { return row_of_[unknown] == kNone; }
  /// In how many rows a free unknown may stand.
  [[nodiscard]] std::size_t uses(std::uint32_t unknown) const { return rows_with_[unknown].size(); }
  /// What gives an unknown that is not free.
  [[nodiscard]] const Row& row_of(std::uint32_t unknown) const { return rows_[row_of_[unknown]]; }
  /// All that is not 0 where this free unknown is not, and the other free ones are. The free one is first. Empty: too
  /// large.
  [[nodiscard]] std::vector<Term> solution(std::uint32_t free) const;

  [[nodiscard]] Row combined(const Row& a, std::int64_t factor_a, const Row& b, std::int64_t factor_b);

 private:
  void add_equation(Row row);
  void eliminate(Row& row, std::uint32_t unknown, const Row& by);
  [[nodiscard]] static std::int64_t factor_of(const Row& row, std::uint32_t unknown);

  std::uint32_t first_reluctant_;
  CancellationToken cancellation_;
  bool is_given_up_ = false;
  std::uint64_t work_ = 0, next_look_ = 0;
  std::vector<Row> rows_;                              // each has one unknown that is in no other: what it gives
  std::vector<std::uint32_t> row_of_;                  // by unknown: the row that gives it, or kNone
  std::vector<std::vector<std::uint32_t>> rows_with_;  // by unknown: where it may stand on the other side
};

}  // namespace bip::verify
