// See sparse_system.hpp.
#include "compiler/verify/invariants/sparse_system.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace bip::verify {

namespace {
// The clock is read once in so much work.
constexpr std::uint64_t kLook = 1'000'000;
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
  if (work_ >= next_look_) {
    next_look_ = work_ + kLook;
    if (cancellation_.is_over()) is_given_up_ = true;
  }
  return !is_given_up_;
}

std::int64_t SparseSystem::factor_of(const Row& row, std::uint32_t unknown) {
  const auto found =
      std::lower_bound(row.begin(), row.end(), unknown, [](const Term& t, std::uint32_t u) { return t.unknown < u; });
  return found != row.end() && found->unknown == unknown ? found->factor : 0;
}

SparseSystem::Row SparseSystem::combined(const Row& a, std::int64_t factor_a, const Row& b, std::int64_t factor_b) {
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
    // Nobody looks at the numbers any more.
    is_given_up_ = true;
    term.factor = 1;
  }
  return sum;
}

// `by` gives the unknown: it goes out of the row.
void SparseSystem::eliminate(Row& row, std::uint32_t unknown, const Row& by) {
  const std::int64_t here = factor_of(row, unknown), there = factor_of(by, unknown);
  if (here == 0) return;
  const std::int64_t common = std::gcd(here, there);
  row = combined(row, there / common, by, -(here / common));
}

void SparseSystem::add_equation(Row row) {
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
  // What it gives: an unknown that stands in few other rows, best without a fraction.
  const auto cost = [&](const Term& t) {
    return std::tuple(t.unknown >= first_reluctant_, t.factor != 1 && t.factor != -1, rows_with_[t.unknown].size());
  };
  const std::uint32_t given = std::min_element(row.begin(), row.end(), [&](const Term& a, const Term& b) {
                                return cost(a) < cost(b);
                              })->unknown;
  const std::vector<std::uint32_t> others = std::move(rows_with_[given]);
  rows_with_[given].clear();
  const auto number = static_cast<std::uint32_t>(rows_.size());
  for (std::uint32_t other : others) {
    eliminate(rows_[other], given, row);
    for (const Term& term : row) {
      std::vector<std::uint32_t>& with = rows_with_[term.unknown];
      if (term.unknown != given && std::find(with.begin(), with.end(), other) == with.end()) with.push_back(other);
      (void)spend(with.size());
    }
    if (is_given_up_) return;
  }
  for (const Term& term : row) {
    if (term.unknown != given) rows_with_[term.unknown].push_back(number);
  }
  row_of_[given] = number;
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
  std::int64_t scale = 1;
  std::vector<Term> given;  // unknown, its factor; the free one's comes after
  std::vector<std::int64_t> of_free;
  for (std::uint32_t number : rows_with_[free]) {
    const Row& row = rows_[number];
    const std::int64_t here = factor_of(row, free);
    if (here == 0) continue;
    for (const Term& term : row) {
      if (row_of_[term.unknown] != number) continue;
      given.push_back(term);
      of_free.push_back(here);
      scale = std::lcm(scale, std::abs(term.factor));
    }
    if (scale > kMaxNumber) return {};
  }
  std::vector<Term> values{{free, scale}};
  for (std::size_t k = 0; k < given.size(); ++k)
    values.push_back({given[k].unknown, -scale / given[k].factor * of_free[k]});
  return values;
}

}  // namespace bip::verify
