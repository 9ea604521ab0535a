// See sparse_system.hpp.
#include "compiler/verify/invariants/sparse_system.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {
// Units of work between two readings of the clock.
constexpr std::uint64_t kWorkPerReading = 1'000'000;
}  // namespace

SparseSystem::Row SparseSystem::row_of_terms(std::vector<Term> terms) {
  std::sort(terms.begin(), terms.end(), [](const Term& a, const Term& b) { return a.unknown < b.unknown; });
  Row row;
  for (const Term& term : terms) {
    if (!row.empty() && row.back().unknown == term.unknown) row.back().factor += term.factor;
    else row.push_back(term);
    if (row.back().factor == 0) row.pop_back();
  }
  return row;
}

bool SparseSystem::spend(std::uint64_t work) {
  work_ += work;
  if (work_ > kMaxWork) is_given_up_ = true;
  if (work_ >= next_clock_reading_) {
    next_clock_reading_ = work_ + kWorkPerReading;
    if (cancellation_.is_over()) is_given_up_ = true;
  }
  return !is_given_up_;
}

std::int64_t SparseSystem::factor_of(const Row& row, std::uint32_t unknown) {
  const auto found =
      std::lower_bound(row.begin(), row.end(), unknown, [](const Term& t, std::uint32_t u) { return t.unknown < u; });
  return found != row.end() && found->unknown == unknown ? found->factor : 0;
}

// Sorted, each unknown once, no factor 0.
bool SparseSystem::is_normal(const Row& row) {
  for (std::size_t k = 0; k < row.size(); ++k) {
    if (row[k].factor == 0 || (k > 0 && row[k - 1].unknown >= row[k].unknown)) return false;
  }
  return true;
}

// A merge of two sorted rows, divided by the common divisor of its factors.
SparseSystem::Row SparseSystem::combined(const Row& a, std::int64_t factor_a, const Row& b, std::int64_t factor_b) {
  BIP_ASSERT(is_normal(a) && is_normal(b), "rows of {} and {} terms", a.size(), b.size());
  Row sum;
  sum.reserve(a.size() + b.size());
  std::int64_t divisor = 0;
  std::size_t i = 0, j = 0;
  while (i < a.size() || j < b.size()) {
    const std::uint32_t unknown = std::min(i < a.size() ? a[i].unknown : kNone, j < b.size() ? b[j].unknown : kNone);
    std::int64_t factor = 0;
    if (i < a.size() && a[i].unknown == unknown) factor += a[i++].factor * factor_a;
    if (j < b.size() && b[j].unknown == unknown) factor += b[j++].factor * factor_b;
    if (factor == 0) continue;
    sum.push_back({unknown, factor});
    if (divisor != 1) divisor = std::gcd(divisor, factor);
  }
  (void)spend(a.size() + b.size());
  for (Term& term : sum) {
    term.factor /= divisor;
    if (term.factor <= kMaxNumber && term.factor >= -kMaxNumber) continue;
    // From here on the numbers mean nothing; 1 only keeps the rows well formed.
    is_given_up_ = true;
    term.factor = 1;
  }
  return sum;
}

// Removes the unknown from the row by a multiple of `by`, whose pivot it is.
void SparseSystem::eliminate(Row& row, std::uint32_t unknown, const Row& by) {
  const std::int64_t factor = factor_of(row, unknown), pivot_factor = factor_of(by, unknown);
  if (factor == 0) return;
  BIP_ASSERT(pivot_factor != 0, "the row does not contain unknown {}", unknown);
  const std::int64_t common = std::gcd(factor, pivot_factor);
  row = combined(row, pivot_factor / common, by, -(factor / common));
  BIP_ASSERT(is_given_up_ || factor_of(row, unknown) == 0, "unknown {} is still there", unknown);
}

// Few other rows contain the pivot, and it has no fraction.
std::uint32_t SparseSystem::choose_pivot(const Row& row) const {
  const auto cost = [&](const Term& t) {
    return std::tuple(t.unknown >= first_reluctant_, t.factor != 1 && t.factor != -1, rows_with_[t.unknown].size());
  };
  return std::min_element(row.begin(), row.end(), [&](const Term& a, const Term& b) { return cost(a) < cost(b); })
      ->unknown;
}

void SparseSystem::add_equation(Row row) {
  BIP_ASSERT(is_normal(row), "an equation of {} terms", row.size());
  // Forward: eliminate the pivots of earlier rows.
  for (bool changed = true; changed && !is_given_up_;) {
    changed = false;
    for (const Term& term : row) {
      if (row_of_[term.unknown] == kNone) continue;
      const std::uint32_t unknown = term.unknown;
      eliminate(row, unknown, rows_[row_of_[unknown]]);
      changed = true;
      break;
    }
  }
  if (row.empty() || is_given_up_) return;
  const std::uint32_t pivot = choose_pivot(row);
  // Backward: eliminate the new pivot from all earlier rows.
  const std::vector<std::uint32_t> others = std::move(rows_with_[pivot]);
  rows_with_[pivot].clear();
  const auto number = static_cast<std::uint32_t>(rows_.size());
  for (std::uint32_t other : others) {
    eliminate(rows_[other], pivot, row);
    for (const Term& term : row) {
      std::vector<std::uint32_t>& with = rows_with_[term.unknown];
      if (term.unknown != pivot && std::find(with.begin(), with.end(), other) == with.end()) with.push_back(other);
      (void)spend(with.size());
    }
    if (is_given_up_) return;
  }
  for (const Term& term : row) {
    if (term.unknown != pivot) rows_with_[term.unknown].push_back(number);
  }
  row_of_[pivot] = number;
  rows_.push_back(std::move(row));
}

void SparseSystem::solve(std::vector<Row> equations) {
  std::stable_sort(equations.begin(), equations.end(), [](const Row& a, const Row& b) { return a.size() < b.size(); });
  for (Row& row : equations) {
    if (is_given_up_) return;
    if (!row.empty()) add_equation(std::move(row));
  }
}

std::vector<SparseSystem::Term> SparseSystem::solution(std::uint32_t free) const {
  BIP_ASSERT(is_free(free), "unknown {} is a pivot", free);
  // The pivot of each row with the free unknown: pivot_factor * pivot + free_factor * free = 0, scaled to integers.
  std::int64_t scale = 1;
  std::vector<Term> pivots;
  std::vector<std::int64_t> free_factors;
  for (std::uint32_t number : rows_with_[free]) {
    const Row& row = rows_[number];
    const std::int64_t free_factor = factor_of(row, free);
    if (free_factor == 0) continue;
    for (const Term& term : row) {
      if (row_of_[term.unknown] != number) continue;
      pivots.push_back(term);
      free_factors.push_back(free_factor);
      scale = std::lcm(scale, std::abs(term.factor));
    }
    if (scale > kMaxNumber) return {};
  }
  std::vector<Term> values{{free, scale}};
  for (std::size_t k = 0; k < pivots.size(); ++k)
    values.push_back({pivots[k].unknown, -scale / pivots[k].factor * free_factors[k]});
  return values;
}

}  // namespace bip::verify
