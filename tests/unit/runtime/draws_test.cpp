// Random numbers of models: means of each distribution within their 99% intervals for fixed seeds, shares of tables,
// what arguments may be, and the scripts of searches.
#include <catch2/catch.hpp>

#include <cmath>
#include <set>
#include <vector>

#include "bip/draws.hpp"

using namespace bip::rt;

namespace {

Cell cell(int value) { return int_cell(value); }
Cell cell(double value) { return float_cell(value); }

/// A distribution with its arguments, and a generator.
struct Drawn {
  template <class... Args>
  explicit Drawn(const char* function, Args... args) : values{Cell{.bits = draw_start(1, 0)}, cell(args)...} {
    for (std::size_t k = 0; k < std::size(kDistributions); ++k) {
      if (std::string_view(kDistributions[k].function) == function) draw = draw_function(k);
    }
    for (Cell& value : values) cells.push_back(&value);
  }
  Cell next() {
    Cell result{};
    REQUIRE(draw(nullptr, &result, cells.data()) == 0);
    return result;
  }
  bool fails() {
    Cell result{};
    return draw(nullptr, &result, cells.data()) != 0;
  }
  std::vector<Cell> values;
  std::vector<Cell*> cells;
  FfiFunction draw = nullptr;
};

constexpr int kDraws = 100'000;
constexpr double kQuantile = 2.5758;  // of 99%

/// The mean of so many draws lies in its interval around the true one.
template <class Value>
void check_mean(Drawn drawn, double mean, double deviation, Value value) {
  double sum = 0;
  for (int k = 0; k < kDraws; ++k) sum += value(drawn.next());
  CHECK(std::fabs(sum / kDraws - mean) < kQuantile * deviation / std::sqrt(kDraws));
}
double as_float(Cell drawn) { return drawn.f; }
double as_int(Cell drawn) { return drawn.i; }
double square(Cell drawn) { return drawn.f * drawn.f; }

double density(double z) { return std::exp(-z * z / 2) / std::sqrt(2 * 3.14159265358979323846); }
double below_z(double z) { return std::erfc(-z / std::sqrt(2.0)) / 2; }

/// Mean and deviation of the standard normal between two ends.
std::pair<double, double> truncated(double low, double high) {
  const double share = below_z(high) - below_z(low);
  const double mean = (density(low) - density(high)) / share;
  const double variance = 1 + (low * density(low) - high * density(high)) / share - mean * mean;
  return {mean, std::sqrt(variance)};
}

}  // namespace

TEST_CASE("means of distributions lie in their 99% intervals") {
  check_mean(Drawn("draw_uniform_int", -3, 6), 1.5, std::sqrt(99.0 / 12), as_int);
  check_mean(Drawn("draw_uniform_float", 2.0, 5.0), 3.5, std::sqrt(9.0 / 12), as_float);
  check_mean(Drawn("draw_exponential", 4.0), 4, 4, as_float);
  check_mean(Drawn("draw_exponential", 1.0), 2, std::sqrt(20.0), square);
  check_mean(Drawn("draw_normal", 10.0, 2.0), 10, 2, as_float);
  check_mean(Drawn("draw_normal", 0.0, 1.0), 1, std::sqrt(2.0), square);
  check_mean(Drawn("draw_flip", 0.3), 0.3, std::sqrt(0.21), as_int);
  check_mean(Drawn("draw_table3", 1, 1.0, 10, 2.0, 100, 5.0), 65.125, std::sqrt(6275.125 - 65.125 * 65.125), as_int);
}

TEST_CASE("the truncated normal has the closed forms' means, and its ends") {
  // Around the mean, long and short; beside it, on both sides; far away, long and short.
  const std::pair<double, double> ends[] = {{-2, 2},    {-0.5, 0.7}, {-3, 0.1}, {0, 4},
                                            {0.5, 0.8}, {-1.5, -1},  {3, 8},    {4, 4.1}};
  for (const auto& [low, high] : ends) {
    INFO(low << " to " << high);
    const auto [mean, deviation] = truncated(low, high);
    check_mean(Drawn("draw_truncated_normal", 5.0, 2.0, 5 + 2 * low, 5 + 2 * high), 5 + 2 * mean, 2 * deviation,
               as_float);
    Drawn drawn("draw_truncated_normal", 0.0, 1.0, low, high);
    for (int k = 0; k < 1000; ++k) {
      const double value = drawn.next().f;
      CHECK((low <= value && value <= high));
    }
  }
  CHECK(Drawn("draw_truncated_normal", 0.0, 1e-200, 1.0, 2.0).next().f == 1.0);
  CHECK(Drawn("draw_truncated_normal", 0.0, 1e-200, -2.0, -1.0).next().f == -1.0);
  CHECK(Drawn("draw_truncated_normal", 0.0, 1.0, 1e9, 2e9).next().f < 1e9 + 1);
}

TEST_CASE("ints are drawn from their ends on, and equally often") {
  Drawn drawn("draw_uniform_int", -2, 2);
  std::vector<int> seen(5, 0);
  for (int k = 0; k < kDraws; ++k) ++seen[static_cast<std::size_t>(drawn.next().i + 2)];
  double statistic = 0;
  for (const int n : seen) statistic += std::pow(n - kDraws / 5.0, 2) / (kDraws / 5.0);
  CHECK(statistic < 13.277);  // chi-square, 4 degrees of freedom, 99%
  CHECK(Drawn("draw_uniform_int", 7, 7).next().i == 7);
  std::set<bool> signs;
  Drawn all("draw_uniform_int", INT32_MIN, INT32_MAX);
  for (int k = 0; k < 100; ++k) signs.insert(all.next().i < 0);
  CHECK(signs.size() == 2);
}

TEST_CASE("a value of weight 0 is never drawn") {
  Drawn table("draw_table4", 1, 0.0, 2, 1.0, 3, 0.0, 4, 0.0);
  for (int k = 0; k < 1000; ++k) CHECK(table.next().i == 2);
  Drawn never("draw_flip", 0.0), always("draw_flip", 1.0);
  for (int k = 0; k < 1000; ++k) CHECK((never.next().i == 0 && always.next().i == 1));
}

TEST_CASE("generators of atoms and seeds differ, and repeat") {
  std::set<std::uint64_t> starts;
  for (std::uint64_t seed = 0; seed < 100; ++seed)
    for (std::uint32_t atom = 0; atom < 100; ++atom) starts.insert(draw_start(seed, atom));
  CHECK(starts.size() == 10'000);
  Drawn once("draw_normal", 0.0, 1.0), again("draw_normal", 0.0, 1.0);
  for (int k = 0; k < 10; ++k) CHECK(once.next().bits == again.next().bits);
  // The first numbers, as semantics.md fixes them.
  Drawn first("draw_uniform_int", 1, 1000);
  CHECK(first.values[0].bits == 0x5e41ab087439611e);
  CHECK(std::vector<int>{first.next().i, first.next().i, first.next().i, first.next().i} ==
        std::vector<int>{694, 972, 427, 807});
}

TEST_CASE("arguments that a distribution cannot have are refused") {
  const double nan = std::nan(""), infinite = INFINITY;
  CHECK(Drawn("draw_uniform_int", 2, 1).fails());
  CHECK(draw_problem().text == "`uniform` cannot draw: low is above high");
  CHECK_FALSE(draw_problem().is_of_search);
  CHECK(Drawn("draw_uniform_float", 1.0, 0.0).fails());
  CHECK(Drawn("draw_uniform_float", 0.0, infinite).fails());
  CHECK(Drawn("draw_uniform_float", nan, 0.0).fails());
  CHECK(Drawn("draw_normal", 0.0, 0.0).fails());
  CHECK(Drawn("draw_normal", nan, 1.0).fails());
  CHECK(Drawn("draw_truncated_normal", 0.0, 1.0, 1.0, 1.0).fails());
  CHECK(Drawn("draw_truncated_normal", 0.0, 1.0, -infinite, 1.0).fails());
  CHECK(Drawn("draw_exponential", 0.0).fails());
  CHECK(Drawn("draw_exponential", infinite).fails());
  CHECK(Drawn("draw_flip", -0.1).fails());
  CHECK(Drawn("draw_flip", nan).fails());
  CHECK(Drawn("draw_table2", 1, -1.0, 2, 2.0).fails());
  CHECK(Drawn("draw_table2", 1, 0.0, 2, 0.0).fails());
  CHECK(Drawn("draw_table2", 1, 1e308, 2, 1e308).fails());
  CHECK_FALSE(Drawn("draw_uniform_float", -1e308, 1e308).fails());
}

TEST_CASE("a generator that no run has started gives no number") {
  Drawn drawn("draw_flip", 0.5);
  drawn.values[0].bits = 0;
  CHECK(drawn.fails());
  CHECK(draw_problem().is_of_search);
}

TEST_CASE("a script takes all combinations, and finds each by its number") {
  Drawn die("draw_uniform_int", 1, 3), coin("draw_flip", 0.25), certain("draw_uniform_int", 9, 9);
  std::set<std::vector<int>> seen;
  std::vector<std::pair<std::uint64_t, std::vector<int>>> numbered;
  double sum = 0;
  DrawScript script;
  do {
    const FollowedScript follow(script);
    std::vector<int> drawn{die.next().i, certain.next().i};
    // The second draw depends on the first.
    if (drawn[0] != 2) drawn.push_back(coin.next().i);
    seen.insert(drawn);
    sum += script.probability();
    numbered.emplace_back(script.number(), drawn);
  } while (script.advance());
  CHECK(seen.size() == 5);
  CHECK(numbered.size() == 5);
  CHECK(sum == Approx(1));
  for (const auto& [number, values] : numbered) {
    DrawScript again(number);
    const FollowedScript follow(again);
    CHECK((die.next().i == values[0] && certain.next().i == 9));
    if (values.size() == 3) CHECK(coin.next().i == values[2]);
  }
  // The generators were not asked.
  CHECK(die.values[0].bits == draw_start(1, 0));
}

TEST_CASE("a script refuses what it cannot take value by value") {
  DrawScript script;
  const FollowedScript follow(script);
  CHECK(Drawn("draw_normal", 0.0, 1.0).fails());
  CHECK(draw_problem().is_of_search);
  CHECK(Drawn("draw_exponential", 1.0).fails());
  CHECK(Drawn("draw_uniform_int", 0, 65536).fails());
  CHECK_FALSE(Drawn("draw_uniform_int", 0, 255).fails());
  CHECK_FALSE(Drawn("draw_uniform_int", 0, 255).fails());
  CHECK(Drawn("draw_flip", 0.5).fails());
  CHECK_FALSE(Drawn("draw_flip", 1.0).fails());
  DrawScript first = DrawScript::without_choices();
  const FollowedScript begin(first);
  CHECK(Drawn("draw_flip", 0.5).fails());
  CHECK_FALSE(Drawn("draw_uniform_int", 4, 4).fails());
  // Wrong arguments are the model's fault, script or not.
  CHECK(Drawn("draw_exponential", -1.0).fails());
  CHECK_FALSE(draw_problem().is_of_search);
}
