// See sub_invariant.hpp.
#include "compiler/verify/counting/sub_invariant.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "compiler/base/log.hpp"
#include "compiler/verify/counting/simplex.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr std::size_t kMostTraps = 40;
constexpr double kNearlyZero = 1e-4;   // tokens: bounds are enlarged by less
constexpr double kNearlyWhole = 1e-6;  // less than k by more: a proof, if rounded weights hold
constexpr std::int64_t kMostScale = 1'000'000, kMostFactor = 10'000;
// Sums of a weight for each component stay below 2^61.
constexpr std::int64_t kMostWeight = std::int64_t{1} << 40, kMostTokens = std::int64_t{1} << 20;
constexpr std::size_t kMostPlacesToShrink = 200;

using Change = std::map<u32, std::int64_t>;  // by place

Change change_of(const CountedNet::Transition& transition) {
  Change change;
  for (const u32 place : transition.from) --change[place];
  for (const u32 place : transition.to) ++change[place];
  std::erase_if(change, [](const auto& row) { return row.second == 0; });
  return change;
}
bool contains(const std::vector<u32>& sorted, u32 place) {
  return std::binary_search(sorted.begin(), sorted.end(), place);
}
std::int64_t tokens_in(const CountedNet& net, const std::vector<u32>& places) {
  std::int64_t sum = 0;
  for (const u32 place : places) sum += net.tokens[place];
  return sum;
}

// Drops places that a transition takes from without putting any token into the rest, until there is none.
std::vector<u32> largest_trap(const CountedNet& net, const std::vector<u32>& places) {
  std::vector<std::uint8_t> is_in(net.places.size(), 0);
  for (const u32 place : places) is_in[place] = 1;
  const auto is_inside = [&](u32 place) { return is_in[place] != 0; };
  for (bool is_shrinking = true; is_shrinking;) {
    is_shrinking = false;
    for (const CountedNet::Transition& transition : net.transitions) {
      if (std::any_of(transition.to.begin(), transition.to.end(), is_inside)) continue;
      for (const u32 place : transition.from) {
        is_shrinking = is_shrinking || is_inside(place);
        is_in[place] = 0;
      }
    }
  }
  std::vector<u32> trap;
  for (const u32 place : places) {
    if (is_inside(place)) trap.push_back(place);
  }
  return trap;
}
// A trap among these places that has a token initially, as small as dropping single places makes it; empty: none.
std::vector<u32> marked_trap(const CountedNet& net, const std::vector<u32>& places) {
  std::vector<u32> trap = largest_trap(net, places);
  if (tokens_in(net, trap) == 0) return {};
  if (trap.size() > kMostPlacesToShrink) return trap;
  for (std::size_t k = trap.size(); k-- > 0;) {
    if (k >= trap.size()) continue;
    std::vector<u32> fewer = trap;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(k));
    fewer = largest_trap(net, fewer);
    if (tokens_in(net, fewer) != 0) trap = std::move(fewer);
  }
  return trap;
}

// The linear program: rows are the places, then the traps; columns the different changes by transitions.
class WeightSearch {
 public:
  WeightSearch(const CountedNet& net, const BadPlaces& bad, const CancellationToken& cancellation)
      : net_(net), bad_(bad), cancellation_(cancellation), gain_(net.places.size(), 0) {
    for (const std::vector<u32>& set : bad.sets) {
      for (const u32 place : set) gain_[place] = 1;
    }
    for (const CountedNet::Transition& transition : net.transitions) changes_.push_back(change_of(transition));
    std::sort(changes_.begin(), changes_.end());
    changes_.erase(std::unique(changes_.begin(), changes_.end()), changes_.end());
  }

  SubInvariantSearch run() {
    const auto places = static_cast<std::ptrdiff_t>(net_.places.size());
    for (;;) {
      const SimplexResult result = maximise(program(), cancellation_);
      const double largest = initial_gain() + result.value, wanted = static_cast<double>(bad_.sets.size());
      BIP_LOG(Portfolio, 1, "marking equation: {} places, {} changes, {} traps: {} of {} after {} pivots",
              net_.places.size(), changes_.size(), traps_.size(),
              result.end == SimplexEnd::Optimal ? largest : std::nan(""), wanted, result.pivots);
      if (result.end == SimplexEnd::Limit) return {};
      if (largest < wanted - kNearlyWhole) return {rounded(result.multipliers), {}};
      if (!add_trap(result.slack)) return {std::nullopt, {result.slack.begin(), result.slack.begin() + places}};
    }
  }

 private:
  [[nodiscard]] double initial_gain() const {
    double sum = 0;
    for (u32 place = 0; place < gain_.size(); ++place) sum += static_cast<double>(gain_[place]) * net_.tokens[place];
    return sum;
  }
  [[nodiscard]] LinearProgram program() const {
    LinearProgram program;
    for (const u32 tokens : net_.tokens) program.bounds.push_back(tokens);
    for (const std::vector<u32>& trap : traps_)
      program.bounds.push_back(static_cast<double>(tokens_in(net_, trap) - 1));
    for (const Change& change : changes_) {
      LinearProgram::Column column;
      std::map<u32, std::int64_t> of_traps;
      for (const auto& [place, by] : change) {
        column.gain += static_cast<double>(by * gain_[place]);
        column.changes.emplace_back(place, static_cast<double>(by));
        for (const u32 trap : traps_of(place)) of_traps[trap] += by;
      }
      for (const auto& [trap, by] : of_traps) {
        if (by != 0) column.changes.emplace_back(static_cast<u32>(net_.places.size()) + trap, static_cast<double>(by));
      }
      program.columns.push_back(std::move(column));
    }
    return program;
  }
  [[nodiscard]] std::vector<u32> traps_of(u32 place) const {
    std::vector<u32> rows;
    for (u32 row = 0; row < traps_.size(); ++row) {
      if (contains(traps_[row], place)) rows.push_back(row);
    }
    return rows;
  }
  bool add_trap(const std::vector<double>& slack) {
    if (traps_.size() >= kMostTraps || cancellation_.is_over()) return false;
    std::vector<u32> empty;
    for (u32 place = 0; place < net_.places.size(); ++place) {
      if (slack[place] < kNearlyZero) empty.push_back(place);
    }
    std::vector<u32> trap = marked_trap(net_, empty);
    if (trap.empty()) return false;
    traps_.push_back(std::move(trap));
    return true;
  }

  // The multipliers as integers. How far they are off by rounding is not known: what is nearer to an integer than a
  // tolerance is one, and only those that hold count.
  [[nodiscard]] std::optional<SubInvariant> rounded(const std::vector<double>& multipliers) const {
    for (const double tolerance : {1e-6, 1e-5, 1e-4, 1e-3}) {
      std::optional<SubInvariant> proof = rounded(multipliers, tolerance);
      if (proof && excludes(net_, bad_, *proof)) return proof;
    }
    BIP_LOG(Portfolio, 1, "marking equation: the weights do not hold in integers");
    return std::nullopt;
  }
  // By their least common denominator.
  [[nodiscard]] std::optional<SubInvariant> rounded(const std::vector<double>& multipliers, double tolerance) const {
    std::int64_t scale = 1;
    const auto is_integer = [&](double value) { return std::abs(value - std::round(value)) < tolerance; };
    for (const double multiplier : multipliers) {
      if (multiplier * static_cast<double>(kMostScale) > static_cast<double>(kMostWeight)) return std::nullopt;
      std::int64_t factor = 1;
      while (!is_integer(multiplier * static_cast<double>(scale * factor))) {
        if (++factor > kMostFactor) return std::nullopt;
      }
      scale *= factor;
      if (scale > kMostScale) return std::nullopt;
    }
    SubInvariant proof;
    proof.scale = scale;
    const auto integer_of = [&](std::size_t row) {
      return std::max<std::int64_t>(0, std::llround(multipliers[row] * static_cast<double>(scale)));
    };
    for (u32 place = 0; place < net_.places.size(); ++place)
      proof.weights.push_back(integer_of(place) + scale * gain_[place]);
    for (std::size_t row = 0; row < traps_.size(); ++row) {
      const std::int64_t factor = integer_of(net_.places.size() + row);
      if (factor == 0) continue;
      for (const u32 place : traps_[row]) proof.weights[place] += factor;
      proof.traps.push_back({traps_[row], factor});
    }
    return proof;
  }

  const CountedNet& net_;
  const BadPlaces& bad_;
  const CancellationToken& cancellation_;
  std::vector<std::int64_t> gain_;  // by place: is it in a set?
  std::vector<Change> changes_;
  std::vector<std::vector<u32>> traps_;
};

}  // namespace

bool excludes(const CountedNet& net, const BadPlaces& bad, const SubInvariant& proof) {
  if (proof.scale <= 0 || proof.weights.size() != net.places.size()) return false;
  const auto is_within = [](std::int64_t value) { return value >= 0 && value <= kMostWeight; };
  if (std::accumulate(net.tokens.begin(), net.tokens.end(), std::int64_t{0}) > kMostTokens) return false;
  std::vector<std::int64_t> least(net.places.size(), 0);
  for (const std::vector<u32>& set : bad.sets) {
    for (const u32 place : set) least[place] += proof.scale;
  }
  std::int64_t sum = 0;
  for (const SubInvariant::WeightedTrap& trap : proof.traps) {
    if (!is_within(trap.factor) || tokens_in(net, trap.places) == 0 ||
        largest_trap(net, trap.places).size() != trap.places.size())
      return false;
    for (const u32 place : trap.places) least[place] += trap.factor;
    sum -= trap.factor;
  }
  for (u32 place = 0; place < net.places.size(); ++place) {
    if (!is_within(proof.weights[place]) || proof.weights[place] < least[place]) return false;
    sum += proof.weights[place] * net.tokens[place];
  }
  if (sum >= proof.scale * static_cast<std::int64_t>(bad.sets.size())) return false;
  return std::all_of(net.transitions.begin(), net.transitions.end(), [&](const CountedNet::Transition& transition) {
    std::int64_t rise = 0;
    for (const u32 place : transition.to) rise += proof.weights[place];
    for (const u32 place : transition.from) rise -= proof.weights[place];
    return rise <= 0;
  });
}

SubInvariantSearch find_sub_invariant(const CountedNet& net, const BadPlaces& bad,
                                      const CancellationToken& cancellation) {
  return WeightSearch(net, bad, cancellation).run();
}

}  // namespace bip::verify
