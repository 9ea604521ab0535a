// Homogeneous linear equations with known solutions; what is too large is given up, never wrong.
#include <catch2/catch.hpp>

#include <map>

#include "compiler/verify/invariants/sparse_system.hpp"

namespace bip::verify {

namespace {

using Row = SparseSystem::Row;

std::map<std::uint32_t, std::int64_t> values_of(const std::vector<SparseSystem::Term>& solution) {
  std::map<std::uint32_t, std::int64_t> values;
  for (const SparseSystem::Term& term : solution) values[term.unknown] = term.factor;
  return values;
}
std::int64_t sum_of(const Row& row, std::map<std::uint32_t, std::int64_t> values) {
  std::int64_t sum = 0;
  for (const SparseSystem::Term& term : row) sum += term.factor * values[term.unknown];
  return sum;
}

}  // namespace

TEST_CASE("sparse system: terms are sorted, added up, and vanish at 0") {
  const Row row = SparseSystem::row_of_terms({{3, 2}, {1, 5}, {3, -2}, {0, 1}, {1, 1}});
  REQUIRE(row.size() == 2);
  CHECK((row[0].unknown == 0 && row[0].factor == 1));
  CHECK((row[1].unknown == 1 && row[1].factor == 6));
}

TEST_CASE("sparse system: a combination has no common divisor") {
  SparseSystem system(3, 3, {});
  const Row sum = system.combined({{0, 2}, {1, 4}}, 3, {{0, -1}, {2, 2}}, 2);
  // 3 * (2a + 4b) + 2 * (-a + 2c) = 4a + 12b + 4c.
  REQUIRE(sum.size() == 3);
  CHECK((sum[0].factor == 1 && sum[1].factor == 3 && sum[2].factor == 1));
}

TEST_CASE("sparse system: one free unknown gives the smallest integers") {
  // a = 2b, 3b = c: the solutions are multiples of (2, 1, 3).
  SparseSystem system(3, 3, {});
  system.solve({{{0, 1}, {1, -2}}, {{1, 3}, {2, -1}}});
  REQUIRE_FALSE(system.is_given_up());
  std::uint32_t free = SparseSystem::kNone, count = 0;
  for (std::uint32_t unknown = 0; unknown < 3; ++unknown) {
    if (!system.is_free(unknown)) continue;
    free = unknown;
    ++count;
  }
  REQUIRE(count == 1);
  CHECK(system.uses(free) == 2);
  const std::map<std::uint32_t, std::int64_t> values = values_of(system.solution(free));
  CHECK(values == std::map<std::uint32_t, std::int64_t>{{0, 2}, {1, 1}, {2, 3}});
}

TEST_CASE("sparse system: equations that depend on each other leave the same free unknowns") {
  const std::vector<Row> equations{{{0, 1}, {1, 1}, {2, -1}}, {{0, 2}, {1, 2}, {2, -2}}, {{1, 1}, {3, -1}}};
  SparseSystem system(4, 4, {});
  system.solve(equations);
  int free = 0;
  for (std::uint32_t unknown = 0; unknown < 4; ++unknown) {
    if (!system.is_free(unknown)) continue;
    ++free;
    const std::map<std::uint32_t, std::int64_t> values = values_of(system.solution(unknown));
    CHECK(values.at(unknown) != 0);
    for (const Row& row : equations) CHECK(sum_of(row, values) == 0);
  }
  CHECK(free == 2);
}

TEST_CASE("sparse system: no solution but 0") {
  SparseSystem system(2, 2, {});
  system.solve({{{0, 1}, {1, 1}}, {{0, 1}, {1, -1}}});
  CHECK_FALSE(system.is_free(0));
  CHECK_FALSE(system.is_free(1));
}

TEST_CASE("sparse system: reluctant unknowns stay free while there are others") {
  SparseSystem system(3, 1, {});
  system.solve({{{0, 5}, {1, 1}, {2, 1}}});
  CHECK_FALSE(system.is_free(0));
  CHECK((system.is_free(1) && system.is_free(2)));
}

TEST_CASE("sparse system: too large numbers, too much work and no time are given up") {
  // Each unknown is 100 times the next: the first weighs 100^6.
  std::vector<Row> chain;
  for (std::uint32_t k = 0; k < 6; ++k) chain.push_back({{k, 1}, {k + 1, -100}});
  SparseSystem large(7, 7, {});
  large.solve(chain);
  CHECK((large.is_given_up() || large.solution(6).empty()));
  SparseSystem busy(2, 2, {});
  CHECK(busy.spend(SparseSystem::kMaxWork));
  CHECK_FALSE(busy.spend(1));
  CHECK(busy.is_given_up());
  SparseSystem late(2, 2, within_seconds(0));
  CHECK_FALSE(late.spend(1));
}

}  // namespace bip::verify
