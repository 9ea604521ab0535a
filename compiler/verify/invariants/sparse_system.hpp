// Homogeneous linear equations over the integers, solved sparsely by Gauss-Jordan elimination: each row gives one pivot
// unknown by the free ones.
//
// Rows are kept without common divisors. Returns small integer solutions, or nothing: the work is given up past
// kMaxWork, when a coefficient exceeds kMaxNumber, or when the time is over. Cost: as sparse as the equations are; the
// pivot is an unknown that stands in few other rows (H. Markowitz: The Elimination Form of the Inverse and its
// Application to Linear Programming, 1957), preferably with factor 1 or -1.
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

  /// Sorts terms that stand in any order and adds up those of one unknown. Does not divide.
  [[nodiscard]] static Row row_of_terms(std::vector<Term> terms);

  /// Unknowns from `first_reluctant` on become pivots only of rows that contain nothing else.
  SparseSystem(std::uint32_t unknowns, std::uint32_t first_reluctant, const CancellationToken& cancellation)
      : first_reluctant_(first_reluctant),
        cancellation_(cancellation),
        row_of_(unknowns, kNone),
        rows_with_(unknowns) {}

  /// Adds the equations, short ones first: that fills least. May be called once.
  void solve(std::vector<Row> equations);
  [[nodiscard]] bool is_given_up() const { return is_given_up_; }
  void give_up() { is_given_up_ = true; }
  /// Counts work that was done elsewhere for this system. False: it is too much.
  bool spend(std::uint64_t work);

  [[nodiscard]] bool is_free(std::uint32_t unknown) const { return row_of_[unknown] == kNone; }
  /// Returns in how many rows a free unknown may stand.
  [[nodiscard]] std::size_t uses(std::uint32_t unknown) const { return rows_with_[unknown].size(); }
  /// Returns the row that gives an unknown that is not free.
  [[nodiscard]] const Row& row_of(std::uint32_t unknown) const { return rows_[row_of_[unknown]]; }
  /// Returns the basis vector of a free unknown: all unknowns that are not 0 where it is not and the other free ones
  /// are. The free one stands first. Empty: a number is too large.
  [[nodiscard]] std::vector<Term> solution(std::uint32_t free) const;

  [[nodiscard]] Row combined(const Row& a, std::int64_t factor_a, const Row& b, std::int64_t factor_b);

 private:
  void add_equation(Row row);
  [[nodiscard]] std::uint32_t choose_pivot(const Row& row) const;
  void eliminate(Row& row, std::uint32_t unknown, const Row& by);
  [[nodiscard]] static bool is_normal(const Row& row);
  [[nodiscard]] static std::int64_t factor_of(const Row& row, std::uint32_t unknown);

  std::uint32_t first_reluctant_;
  CancellationToken cancellation_;
  bool is_given_up_ = false;
  std::uint64_t work_ = 0, next_clock_reading_ = 0;
  std::vector<Row> rows_;                              // each has one pivot, which is in no other row
  std::vector<std::uint32_t> row_of_;                  // by unknown: the row that it is the pivot of, or kNone
  std::vector<std::vector<std::uint32_t>> rows_with_;  // by unknown that is no pivot: rows that it may stand in
};

}  // namespace bip::verify
