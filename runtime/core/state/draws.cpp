// See bip/draws.hpp. A distribution checks its arguments, then draws: from the generator in its cell, or from the
// script of a search.
#include "bip/draws.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "bip/assert.hpp"
#include "bip/prng.hpp"

namespace bip::rt {

namespace {

constexpr std::uint64_t kGrowth = 0x9e3779b97f4a7c15u;
// Rows of kDistributions.
enum : std::size_t { kUniformInt, kUniformFloat, kNormal, kTruncatedNormal, kExponential, kFlip, kTable };
constexpr double kFarthest = 1e150;  // standard deviations

std::uint64_t scrambled(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

/// The generator in a cell.
class DrawGenerator {
 public:
  explicit DrawGenerator(Cell& cell) : cell_(cell) {}
  std::uint64_t next() { return scrambled(cell_.bits += kGrowth); }
  /// In [0, 1): a multiple of 2^-53.
  double share() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  /// In (0, 1].
  double positive_share() { return static_cast<double>((next() >> 11) + 1) * 0x1p-53; }

 private:
  Cell& cell_;
};

thread_local DrawScript* script_of_thread = nullptr;
thread_local DrawProblem problem_of_thread;

std::int32_t refuse_arguments(std::string text) {
  problem_of_thread = {std::move(text), false};
  return 1;
}
std::int32_t refuse_search(std::string text) {
  problem_of_thread = {std::move(text), true};
  return 1;
}

std::int32_t store_draw(Cell* result, std::int32_t value) {
  *result = int_cell(value);
  return 0;
}
std::int32_t store_draw(Cell* result, double value) {
  *result = float_cell(value);
  return 0;
}

// A generator that no run has seeded gives no numbers: code that takes steps outside of a run follows a script.
std::int32_t check_seeded(const Cell& generator, const char* name) {
  if (generator.bits != 0) return 0;
  return refuse_search("`" + std::string(name) + "` is drawn outside of a run");
}
std::int32_t refuse_values(const char* name, const std::string& count) {
  return refuse_search("`" + std::string(name) + "` has " + count + " values, and a search takes them one by one");
}
// The script's choice among values with these shares. Negative: a fault.
std::int64_t choose_value(const char* name, const std::vector<double>& shares) {
  const char* problem_of_script =
      shares.size() > 1 && !script_of_thread->has_choices()
          ? "` draws while a component is initialized, and a search begins in one state"
      : !script_of_thread->has_room(shares.size())
          ? "` and the draws before it in this step have too many values together for a search"
          : nullptr;
  if (problem_of_script == nullptr) return static_cast<std::int64_t>(script_of_thread->choose(shares));
  (void)refuse_search("`" + std::string(name) + problem_of_script);
  return -1;
}

// The arguments behind the generator.
struct DrawArguments {
  // False: they are none of the distribution's.
  bool read(std::size_t distribution, Cell* const* args) {
    const ProbabilityDistribution& row = kDistributions[distribution];
    double numbers[kMostDrawArguments];
    std::size_t k = 0;
    for (const char* kind = row.params; *kind != '\0'; ++kind, ++k) {
      cells[k] = *args[k + 1];
      numbers[k] = *kind == 'i' ? static_cast<double>(cells[k].i) : cells[k].f;
    }
    const char* wrong = argument_problem(row, numbers);
    if (wrong != nullptr) (void)refuse_arguments("`" + std::string(row.name) + "` cannot draw: " + wrong);
    return wrong == nullptr;
  }
  Cell cells[kMostDrawArguments];
};

// ---- the normal distribution

/// Standard normal, by Box and Muller (1958); the second number of the pair is not used, so that a draw is a function
/// of the counter.
double standard_normal(DrawGenerator& generator) {
  const double radius = std::sqrt(-2 * std::log(generator.positive_share()));
  return radius * std::cos(2 * 3.14159265358979323846 * generator.share());
}

/// Standard normal between low and high, low >= 0, by Robert, "Simulation of truncated normal variables" (Statistics
/// and Computing 5, 1995): below a translated exponential if the interval is long, else below a constant.
double normal_tail(DrawGenerator& generator, double low, double high) {
  const double rate = (low + std::sqrt(low * low + 4)) / 2;
  const bool is_long = (high - low) * rate > 1;
  while (true) {
    const double z =
        is_long ? low - std::log(generator.positive_share()) / rate : low + (high - low) * generator.share();
    const double exponent = is_long ? -(z - rate) * (z - rate) / 2 : (low * low - z * z) / 2;
    if (z <= high && generator.share() <= std::exp(exponent)) return z;
  }
}

double standard_between(DrawGenerator& generator, double low, double high) {
  if (low >= 0) return normal_tail(generator, low, high);
  if (high <= 0) return -normal_tail(generator, -high, -low);
  // 0 is within. A long interval takes a normal number in most trials, in a short one a constant is a close bound.
  const bool is_long = high - low > 2.5;
  while (true) {
    const double z = is_long ? standard_normal(generator) : low + (high - low) * generator.share();
    if (is_long ? z >= low && z <= high : generator.share() <= std::exp(-z * z / 2)) return z;
  }
}

template <std::size_t Rows>
std::int32_t draw_table(Cell* result, Cell* const* args) {
  DrawArguments values;
  if (!values.read(kTable + Rows - 2, args)) return 1;
  double sum = 0;
  for (std::size_t k = 0; k < Rows; ++k) sum += values.cells[2 * k + 1].f;
  if (script_of_thread != nullptr) {
    std::vector<double> shares;
    std::vector<std::int32_t> of;
    for (std::size_t k = 0; k < Rows; ++k) {
      if (!(values.cells[2 * k + 1].f > 0)) continue;
      shares.push_back(values.cells[2 * k + 1].f / sum);
      of.push_back(values.cells[2 * k].i);
    }
    const std::int64_t k = choose_value("table", shares);
    return k < 0 ? 1 : store_draw(result, of[static_cast<std::size_t>(k)]);
  }
  if (check_seeded(*args[0], "table") != 0) return 1;
  double left = DrawGenerator(*args[0]).share() * sum;
  std::size_t last = 0;
  for (std::size_t k = 0; k < Rows; ++k) {
    const double weight = values.cells[2 * k + 1].f;
    if (!(weight > 0)) continue;
    last = k;
    if (left < weight) break;
    left -= weight;
  }
  return store_draw(result, values.cells[2 * last].i);
}

constexpr FfiFunction kFunctions[] = {
    &draw_uniform_int, &draw_uniform_float, &draw_normal, &draw_truncated_normal, &draw_exponential,
    &draw_flip,        &draw_table2,        &draw_table3, &draw_table4,           &draw_table5,
    &draw_table6,      &draw_table7,        &draw_table8,
};
static_assert(std::size(kFunctions) == std::size(kDistributions));

}  // namespace

std::uint64_t draw_start(std::uint64_t seed, std::uint32_t atom) {
  const std::uint64_t start = scrambled(scrambled(seed + kGrowth) + (std::uint64_t{atom} + 1) * kGrowth);
  return start == 0 ? 1 : start;
}

FfiFunction draw_function(std::size_t k) { return kFunctions[k]; }

const DrawProblem& draw_problem() { return problem_of_thread; }

DrawScript DrawScript::without_choices() {
  DrawScript script;
  script.has_choices_ = false;
  return script;
}

bool DrawScript::advance() {
  next_ = 0;
  for (; !draws_.empty(); draws_.pop_back()) {
    if (++draws_.back().value < draws_.back().shares.size()) return true;
  }
  return false;
}

// Mixed radix: the first draw is the lowest digit.
std::uint64_t DrawScript::number() const {
  std::uint64_t sum = 0, place = 1;
  for (const Draw& draw : draws_) {
    sum += place * draw.value;
    place *= draw.shares.size();
  }
  return sum;
}

double DrawScript::probability() const {
  double product = 1;
  for (const Draw& draw : draws_) product *= draw.shares[draw.value];
  return product;
}

bool DrawScript::has_room(std::uint64_t values) const {
  for (std::size_t k = 0; k < next_; ++k) values *= draws_[k].shares.size();
  return values <= kMostValues;
}

// Draws before the last one of the combination are as they were: the step is a function of them.
std::uint64_t DrawScript::choose(const std::vector<double>& shares) {
  BIP_ASSERT(!shares.empty() && next_ <= draws_.size(), "draw {} of {}", next_, draws_.size());
  if (next_ == draws_.size()) {
    draws_.push_back({rest_ % shares.size(), shares});
    rest_ /= shares.size();
  }
  return draws_[next_++].value;
}

FollowedScript::FollowedScript(DrawScript& script) : before_(script_of_thread) { script_of_thread = &script; }
FollowedScript::~FollowedScript() { script_of_thread = before_; }

std::int32_t draw_uniform_int(FfiContext*, Cell* result, Cell* const* args) {
  DrawArguments values;
  if (!values.read(kUniformInt, args)) return 1;
  const std::int64_t low = values.cells[0].i;
  const std::uint64_t count = static_cast<std::uint64_t>(std::int64_t{values.cells[1].i} - low) + 1;
  if (script_of_thread != nullptr) {
    if (count > DrawScript::kMostValues) return refuse_values("uniform", std::to_string(count));
    const std::int64_t k = choose_value("uniform", std::vector<double>(count, 1.0 / static_cast<double>(count)));
    return k < 0 ? 1 : store_draw(result, static_cast<std::int32_t>(low + k));
  }
  if (check_seeded(*args[0], "uniform") != 0) return 1;
  DrawGenerator generator(*args[0]);
  return store_draw(result, static_cast<std::int32_t>(low + static_cast<std::int64_t>(below(generator, count))));
}

std::int32_t draw_uniform_float(FfiContext*, Cell* result, Cell* const* args) {
  DrawArguments values;
  if (!values.read(kUniformFloat, args)) return 1;
  const double low = values.cells[0].f, high = values.cells[1].f;
  if (low == high) return store_draw(result, low);
  if (script_of_thread != nullptr) return refuse_values("uniform", "infinitely many");
  if (check_seeded(*args[0], "uniform") != 0) return 1;
  // The difference of both may be beyond the largest number.
  const double share = DrawGenerator(*args[0]).share();
  return store_draw(result, std::clamp(low * (1 - share) + high * share, low, std::nextafter(high, low)));
}

std::int32_t draw_normal(FfiContext*, Cell* result, Cell* const* args) {
  DrawArguments values;
  if (!values.read(kNormal, args)) return 1;
  if (script_of_thread != nullptr) return refuse_values("normal", "infinitely many");
  if (check_seeded(*args[0], "normal") != 0) return 1;
  DrawGenerator generator(*args[0]);
  return store_draw(result, values.cells[0].f + values.cells[1].f * standard_normal(generator));
}

std::int32_t draw_truncated_normal(FfiContext*, Cell* result, Cell* const* args) {
  DrawArguments values;
  if (!values.read(kTruncatedNormal, args)) return 1;
  if (script_of_thread != nullptr) return refuse_values("normal", "infinitely many");
  if (check_seeded(*args[0], "normal") != 0) return 1;
  const double mean = values.cells[0].f, deviation = values.cells[1].f;
  const double low = values.cells[2].f, high = values.cells[3].f;
  // So far out the distribution is its nearer end, as precisely as numbers are.
  const double from = (low - mean) / deviation, to = (high - mean) / deviation;
  if (!(from < kFarthest)) return store_draw(result, low);
  if (!(to > -kFarthest)) return store_draw(result, high);
  DrawGenerator generator(*args[0]);
  const double z = standard_between(generator, from, to);
  return store_draw(result, std::clamp(mean + deviation * z, low, high));
}

std::int32_t draw_exponential(FfiContext*, Cell* result, Cell* const* args) {
  DrawArguments values;
  if (!values.read(kExponential, args)) return 1;
  if (script_of_thread != nullptr) return refuse_values("exponential", "infinitely many");
  if (check_seeded(*args[0], "exponential") != 0) return 1;
  return store_draw(result, -values.cells[0].f * std::log(DrawGenerator(*args[0]).positive_share()));
}

std::int32_t draw_flip(FfiContext*, Cell* result, Cell* const* args) {
  DrawArguments values;
  if (!values.read(kFlip, args)) return 1;
  const double share = values.cells[0].f;
  if (script_of_thread != nullptr) {
    if (share == 0 || share == 1) return store_draw(result, share == 1 ? 1 : 0);
    const std::int64_t k = choose_value("flip", {1 - share, share});
    return k < 0 ? 1 : store_draw(result, static_cast<std::int32_t>(k));
  }
  if (check_seeded(*args[0], "flip") != 0) return 1;
  return store_draw(result, DrawGenerator(*args[0]).share() < share ? 1 : 0);
}

std::int32_t draw_table2(FfiContext*, Cell* result, Cell* const* args) { return draw_table<2>(result, args); }
std::int32_t draw_table3(FfiContext*, Cell* result, Cell* const* args) { return draw_table<3>(result, args); }
std::int32_t draw_table4(FfiContext*, Cell* result, Cell* const* args) { return draw_table<4>(result, args); }
std::int32_t draw_table5(FfiContext*, Cell* result, Cell* const* args) { return draw_table<5>(result, args); }
std::int32_t draw_table6(FfiContext*, Cell* result, Cell* const* args) { return draw_table<6>(result, args); }
std::int32_t draw_table7(FfiContext*, Cell* result, Cell* const* args) { return draw_table<7>(result, args); }
std::int32_t draw_table8(FfiContext*, Cell* result, Cell* const* args) { return draw_table<8>(result, args); }

}  // namespace bip::rt
