// See markov_chain.hpp. States are found breadth first by a core of their own; the solver is Gauss-Seidel.
#include "compiler/library/markov_chain.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <unordered_map>

#include <fmt/format.h>

#include "runtime/include/bip/assert.hpp"
#include "runtime/include/bip/draws.hpp"

namespace bip::library {
namespace {

constexpr std::uint64_t kMostSweeps = 10'000'000;

template <class T>
void append_bytes(std::string& key, const std::vector<T>& row) {
  key.append(reinterpret_cast<const char*>(row.data()), row.size() * sizeof(T));
}

std::string key_of(const rt::State& state) {
  std::string key;
  append_bytes(key, state.places);
  append_bytes(key, state.marks);
  append_bytes(key, state.data.rows());
  return key;
}

/// Grows a chain state by state.
class ChainBuilder {
 public:
  ChainBuilder(const rt::Image& image, rt::MaximalProgress progress, std::uint32_t most_states)
      : core_(image, {.progress = progress}), most_states_(most_states) {}

  Result<MarkovChain> build(const std::vector<std::function<bool(const rt::Core&)>>& conditions,
                            std::vector<StateSet>& sets) {
    sets.assign(conditions.size(), {});
    rt::DrawScript script = rt::DrawScript::without_choices();
    if (const rt::FollowedScript follow(script); !core_.initialize())
      return Failure{"the initial state is a run-time error: " + core_.fault().what};
    (void)number_of(core_.snapshot());
    chain_.first.push_back(0);
    for (std::uint32_t state = 0; state < states_.size(); ++state) {
      if (states_.size() > most_states_) return Failure{fmt::format("it has more than {} states", most_states_)};
      if (!core_.restore(states_[state])) return Failure{core_.fault().what};
      for (std::size_t k = 0; k < conditions.size(); ++k) sets[k].push_back(conditions[k](core_) ? 1 : 0);
      if (std::string wrong = expand(state); !wrong.empty()) return Failure{std::move(wrong)};
    }
    return std::move(chain_);
  }

 private:
  std::uint32_t number_of(rt::State state) {
    const auto [at, is_new] = numbers_.try_emplace(key_of(state), static_cast<std::uint32_t>(states_.size()));
    if (is_new) states_.push_back(std::move(state));
    return at->second;
  }

  // The core is in the state. Empty: no step fails.
  std::string expand(std::uint32_t state) {
    const std::uint64_t count = core_.candidate_count();
    chain_.is_end.push_back(count == 0 ? 1 : 0);
    std::vector<double> weights(count, 1);
    for (std::uint64_t k = 0; core_.weights().any() && k < count; ++k)
      weights[k] = core_.weights().weight(core_.position(k));
    double total = 0;
    for (const double weight : weights) total += weight;
    BIP_ASSERT(count == 0 || total > 0, "{} candidates of state {} weigh {} together", count, state, total);
    std::map<std::uint32_t, double> steps;
    if (count == 0) steps[state] = 1;
    for (std::uint64_t k = 0; k < count; ++k) {
      rt::DrawScript script;
      const rt::FollowedScript follow(script);
      bool is_first = k == 0;
      do {
        if (!is_first && !core_.restore(states_[state])) return core_.fault().what;
        is_first = false;
        if (!core_.fire(k)) return "a step ends in a run-time error: " + core_.fault().what;
        steps[number_of(core_.snapshot())] += weights[k] / total * script.probability();
      } while (script.advance());
    }
    for (const auto& [to, share] : steps) {
      if (share < kLeastProbability) return fmt::format("a step has a probability below {:.3g}", kLeastProbability);
      chain_.to.push_back(to);
      chain_.share.push_back(share);
    }
    chain_.first.push_back(chain_.to.size());
    return {};
  }

  rt::Core core_;
  std::uint32_t most_states_;
  MarkovChain chain_;
  std::vector<rt::State> states_;
  std::unordered_map<std::string, std::uint32_t> numbers_;
};

// The states from which one of `target` can be reached by states in `through`; those of `target` themselves.
StateSet can_reach(const MarkovChain& chain, const StateSet& target, const StateSet& through) {
  const std::uint32_t n = chain.states();
  std::vector<std::uint64_t> first(n + 1, 0);
  for (const std::uint32_t to : chain.to) ++first[to + 1];
  for (std::uint32_t s = 0; s < n; ++s) first[s + 1] += first[s];
  std::vector<std::uint32_t> from(chain.to.size());
  std::vector<std::uint64_t> next(first.begin(), first.end() - 1);
  for (std::uint32_t s = 0; s < n; ++s) {
    for (std::uint64_t e = chain.first[s]; e < chain.first[s + 1]; ++e) from[next[chain.to[e]]++] = s;
  }
  BIP_ASSERT(target.size() == n && through.size() == n && next.back() == chain.to.size(), "{} and {} of {} states",
             target.size(), through.size(), n);
  StateSet reached = target;
  std::vector<std::uint32_t> todo;
  for (std::uint32_t s = 0; s < n; ++s) {
    if (target[s] != 0) todo.push_back(s);
  }
  while (!todo.empty()) {
    const std::uint32_t s = todo.back();
    todo.pop_back();
    for (std::uint64_t e = first[s]; e < first[s + 1]; ++e) {
      if (reached[from[e]] != 0 || through[from[e]] == 0) continue;
      reached[from[e]] = 1;
      todo.push_back(from[e]);
    }
  }
  return reached;
}

// Can a run be in a goal after so many steps at most, in states that stay before?
bool is_reachable(const MarkovChain& chain, const StateSet& stays, const StateSet& goal, std::uint64_t most_steps) {
  StateSet is_met(chain.states(), 0);
  std::vector<std::uint32_t> level{0};
  is_met[0] = 1;
  for (std::uint64_t steps = 0; !level.empty(); ++steps) {
    std::vector<std::uint32_t> next;
    for (const std::uint32_t s : level) {
      if (goal[s] != 0) return true;
      if (stays[s] == 0) continue;
      for (std::uint64_t e = chain.first[s]; e < chain.first[s + 1]; ++e) {
        if (is_met[chain.to[e]] == 0) next.push_back(chain.to[e]);
        is_met[chain.to[e]] = 1;
      }
    }
    if (steps == most_steps) return false;
    level = std::move(next);
  }
  return false;
}

Interval without_lost_digits(const Interval& found, const MarkovChain& chain, const StateSet& stays,
                             const StateSet& goal, std::uint64_t most_steps) {
  if (found.high >= kLeastProbability || !is_reachable(chain, stays, goal, most_steps)) return found;
  return {0, kLeastProbability};
}

// What a state's value is, given those of the others: its steps to itself are solved for.
double relaxed(const MarkovChain& chain, std::uint32_t s, const std::vector<double>& value, double added) {
  // Not 1 less the share that stays: a rare step out is lost in that, and then the quotient is one by 0.
  double sum = added, leaves = 0;
  for (std::uint64_t e = chain.first[s]; e < chain.first[s + 1]; ++e) {
    if (chain.to[e] == s) continue;
    leaves += chain.share[e];
    sum += chain.share[e] * value[chain.to[e]];
  }
  return sum / leaves;
}

}  // namespace

Result<MarkovChain> build_chain(const rt::Image& image, rt::MaximalProgress progress, std::uint32_t most_states,
                                const std::vector<std::function<bool(const rt::Core&)>>& conditions,
                                std::vector<StateSet>& sets) {
  return ChainBuilder(image, progress, most_states).build(conditions, sets);
}

Interval reach_probability(const MarkovChain& chain, const StateSet& stays, const StateSet& goal,
                           std::uint64_t most_steps) {
  const std::uint32_t n = chain.states();
  BIP_ASSERT(stays.size() == n && goal.size() == n, "{} and {} of {} states", stays.size(), goal.size(), n);
  std::vector<double> low(n), high(n);
  for (std::uint32_t s = 0; s < n; ++s) low[s] = goal[s];
  if (most_steps != ~std::uint64_t{0}) {
    for (std::uint64_t k = 0; k < most_steps; ++k) {
      bool has_changed = false;
      for (std::uint32_t s = 0; s < n; ++s) {
        high[s] = goal[s];
        if (goal[s] != 0 || stays[s] == 0) continue;
        for (std::uint64_t e = chain.first[s]; e < chain.first[s + 1]; ++e)
          high[s] += chain.share[e] * low[chain.to[e]];
        has_changed |= high[s] != low[s];
      }
      low.swap(high);
      if (!has_changed) break;
    }
    return without_lost_digits({low[0], low[0]}, chain, stays, goal, most_steps);
  }
  StateSet through(n), never(n);
  for (std::uint32_t s = 0; s < n; ++s) through[s] = stays[s] != 0 && goal[s] == 0 ? 1 : 0;
  const StateSet maybe = can_reach(chain, goal, through);
  for (std::uint32_t s = 0; s < n; ++s) never[s] = maybe[s] != 0 ? 0 : 1;
  const StateSet not_sure = can_reach(chain, never, through);
  std::vector<std::uint32_t> open;
  for (std::uint32_t s = 0; s < n; ++s) {
    const bool is_sure = maybe[s] != 0 && not_sure[s] == 0;
    low[s] = is_sure ? 1 : 0;
    high[s] = maybe[s] != 0 ? 1 : 0;
    if (maybe[s] != 0 && not_sure[s] != 0) open.push_back(s);
  }
  // States found late are nearer to where runs go.
  std::reverse(open.begin(), open.end());
  for (std::uint64_t sweep = 0;
       sweep < kMostSweeps && high[0] >= kLeastProbability && high[0] - low[0] > kPrecision * high[0]; ++sweep) {
    for (const std::uint32_t s : open) {
      low[s] = std::max(low[s], relaxed(chain, s, low, 0));
      high[s] = std::min(high[s], relaxed(chain, s, high, 0));
    }
  }
  BIP_ASSERT(low[0] <= high[0] + kPrecision, "a probability from {} to {}", low[0], high[0]);
  return without_lost_digits({low[0], high[0]}, chain, stays, goal, most_steps);
}

double expected_steps(const MarkovChain& chain, const StateSet& goal) {
  BIP_ASSERT(goal.size() == chain.states(), "{} of {} states", goal.size(), chain.states());
  const std::uint32_t n = chain.states();
  StateSet through(n), never(n);
  for (std::uint32_t s = 0; s < n; ++s) through[s] = goal[s] != 0 ? 0 : 1;
  const StateSet maybe = can_reach(chain, goal, through);
  for (std::uint32_t s = 0; s < n; ++s) never[s] = maybe[s] != 0 ? 0 : 1;
  const StateSet not_sure = can_reach(chain, never, through);
  if (not_sure[0] != 0) return std::numeric_limits<double>::infinity();
  std::vector<double> value(n, 0);
  double growth = 1;
  for (std::uint64_t sweep = 0; sweep < kMostSweeps && growth > kPrecision / 100; ++sweep) {
    growth = 0;
    for (std::uint32_t s = n; s-- > 0;) {
      if (goal[s] != 0 || not_sure[s] != 0) continue;
      // To wait a step more costs each round: 1 / (1 - stay) on the whole.
      const double now = relaxed(chain, s, value, 1);
      growth = std::max(growth, (now - value[s]) / now);
      value[s] = now;
    }
  }
  return value[0];
}

std::string prism_text(const MarkovChain& chain, const std::string& title, const std::vector<std::string>& names,
                       const std::vector<StateSet>& sets) {
  BIP_ASSERT(names.size() == sets.size(), "{} names of {} sets", names.size(), sets.size());
  std::string out = fmt::format("// {}: the Markov chain of its runs under the policy uniform, {} states.\ndtmc\n\n",
                                title, chain.states());
  // PRISM wants a range with two values.
  out += fmt::format("module system\n  s : [0..{}] init 0;\n", std::max(chain.states() - 1, 1u));
  for (std::uint32_t s = 0; s < chain.states(); ++s) {
    out += fmt::format("  [] s={} -> ", s);
    for (std::uint64_t e = chain.first[s]; e < chain.first[s + 1]; ++e)
      out += fmt::format("{}{} : (s'={})", e == chain.first[s] ? "" : " + ", chain.share[e], chain.to[e]);
    out += ";\n";
  }
  out += "endmodule\n\n";
  const auto label = [&](const std::string& name, const StateSet& set) {
    std::string text;
    for (std::uint32_t s = 0; s < chain.states(); ++s) {
      if (set[s] == 0) continue;
      std::uint32_t last = s;
      while (last + 1 < chain.states() && set[last + 1] != 0) ++last;
      text += text.empty() ? "" : " | ";
      text += s == last ? fmt::format("s={}", s) : fmt::format("(s>={} & s<={})", s, last);
      s = last;
    }
    out += fmt::format("label \"{}\" = {};\n", name, text.empty() ? "false" : text);
  };
  label("end", chain.is_end);
  for (std::size_t k = 0; k < names.size(); ++k) label(names[k], sets[k]);
  return out;
}

}  // namespace bip::library
