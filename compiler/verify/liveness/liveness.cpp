// See liveness.hpp.
#include "compiler/verify/liveness/liveness.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "compiler/verify/liveness/automaton.hpp"
#include "compiler/verify/liveness/bad_prefix.hpp"
#include "compiler/verify/liveness/components.hpp"
#include "compiler/verify/liveness/fair_units.hpp"
#include "compiler/verify/liveness/lasso.hpp"
#include "compiler/verify/liveness/product.hpp"
#include "compiler/verify/liveness/graph_rounds.hpp"
#include "compiler/verify/property/expression.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// For the remark that fairness would help.
constexpr std::uint32_t kStatesOfRemark = 200'000;
constexpr double kSecondsOfRemark = 2;

// What is tried for that remark: all that is weak strong, and, where only things with names are spoken of, each
// interaction.
std::vector<Fairness> stronger_than(const Fairness& fairness) {
  std::vector<Fairness> stronger;
  if (fairness.has(FairnessKind::Weak)) {
    Fairness& strong = stronger.emplace_back(fairness);
    for (FairnessTerm& term : strong.terms) term.kind = FairnessKind::Strong;
    for (WrittenTerm& term : strong.written) term.kind = FairnessKind::Strong;
  }
  const bool has_names = std::all_of(fairness.terms.begin(), fairness.terms.end(),
                                     [](const FairnessTerm& term) { return term.has_name(); });
  if (!has_names) return stronger;
  stronger.push_back(fairness_of_interactions(FairnessKind::Weak));
  if (!fairness.is_none()) stronger.push_back(stronger.back());
  Fairness& weak = stronger.back();
  weak.terms.insert(weak.terms.end(), fairness.terms.begin(), fairness.terms.end());
  weak.written.insert(weak.written.end(), fairness.written.begin(), fairness.written.end());
  // It implies all that was said: of the interactions of a connector, one is possible again and again if they all are.
  stronger.push_back(fairness_of_interactions(FairnessKind::Strong));
  return stronger;
}

// A run as the core takes it: a position has a state and the step that leaves it.
class LassoReplay {
 public:
  LassoReplay(const Formula& formula, const rt::Image& image, rt::StateGraph& graph)
      : formula_(formula), graph_(graph), core_(image) {}

  /// Takes the run. False: a step is not possible, or the cycle does not close.
  bool run(const Lasso& lasso) {
    if (!core_.initialize()) return false;
    for (const LassoStep& step : lasso.stem) {
      if (!take(step)) return false;
    }
    cycle_ = choices_.size();
    BIP_ASSERT(cycle_ == lasso.stem.size(), "{} of {} steps of the stem were taken", cycle_, lasso.stem.size());
    for (const LassoStep& step : lasso.cycle) {
      note_possible();
      if (!take(step)) return false;
    }
    if (!lasso.cycle.empty()) {
      const std::uint32_t begin = lasso.stem.empty() ? 0 : lasso.stem.back().state;
      return lasso.cycle.back().state == begin;
    }
    note_position(0);
    return core_.candidate_count() == 0;
  }
  /// The same of a run that needs no end. The last position is that of its last state, or of its last step.
  bool run(const BadPrefix& prefix) {
    if (!core_.initialize()) return false;
    for (const LassoStep& step : prefix.steps) {
      if (!take(step)) return false;
    }
    const std::uint32_t more = prefix.repeats + (prefix.ends_with_step ? 0 : 1);
    for (std::uint32_t k = 0; k < more; ++k) note_position(0);
    return prefix.repeats == 0 || core_.candidate_count() == 0;
  }
  /// Of an invariant, at the last position.
  [[nodiscard]] bool violates_at_last() const {
    return !holds_at_last(formula_, formula_.nodes[formula_.root].b, states_, steps_);
  }
  [[nodiscard]] bool violates() const { return !holds_on_lasso(formula_, states_, steps_, cycle_); }
  [[nodiscard]] bool is_fair(const Fairness& fairness) const {
    BIP_ASSERT(labels_.size() == choices_.size() && cycle_ <= choices_.size(),
               "{} labels of {} steps, the cycle from {}", labels_.size(), choices_.size(), cycle_);
    if (fairness.is_none()) return true;
    const FairUnits units(graph_.labels(), fairness);
    std::set<std::uint32_t> taken;
    for (std::size_t at = cycle_; at < labels_.size(); ++at)
      taken.insert(units.of(labels_[at]).begin(), units.of(labels_[at]).end());
    std::vector<std::size_t> possible(units.size(), 0);
    for (const std::set<std::uint32_t>& labels : possible_) {
      std::set<std::uint32_t> enabled_units;
      for (const std::uint32_t label : labels) enabled_units.insert(units.of(label).begin(), units.of(label).end());
      for (const std::uint32_t unit : enabled_units) ++possible[unit];
    }
    for (std::uint32_t unit = 0; unit < units.size(); ++unit) {
      const bool is_due = units.is_strong(unit) ? possible[unit] != 0 : possible[unit] == possible_.size();
      if (!possible_.empty() && is_due && taken.count(unit) == 0) return false;
    }
    return true;
  }
  /// Of a run that is fair and repeats: by term with a name.
  [[nodiscard]] std::vector<FairTurn> turns(const Fairness& fairness) const {
    const FairUnits units(graph_.labels(), fairness);
    const auto has = [&](std::uint32_t label, std::uint32_t unit) {
      return std::binary_search(units.of(label).begin(), units.of(label).end(), unit);
    };
    std::vector<FairTurn> turns;
    for (std::size_t term = 0; term < fairness.terms.size() && !possible_.empty(); ++term) {
      if (!fairness.terms[term].has_name()) continue;
      const std::uint32_t unit = units.of_term(term);
      const auto first = [&](const auto& is_so) {
        std::size_t at = cycle_;
        while (at < labels_.size() && !is_so(at)) ++at;
        return at;
      };
      const std::size_t happens = first([&](std::size_t at) { return has(labels_[at], unit); });
      const auto is_possible = [&](std::size_t at) {
        const std::set<std::uint32_t>& labels = possible_[at - cycle_];
        return std::any_of(labels.begin(), labels.end(), [&](std::uint32_t label) { return has(label, unit); });
      };
      if (happens != labels_.size()) turns.push_back({FairTurn::Why::Happens, happens});
      else if (first(is_possible) == labels_.size()) turns.push_back({FairTurn::Why::NeverPossible});
      else turns.push_back({FairTurn::Why::Impossible, first([&](std::size_t at) { return !is_possible(at); })});
    }
    return turns;
  }
  [[nodiscard]] const std::vector<std::uint64_t>& choices() const { return choices_; }
  [[nodiscard]] std::size_t cycle() const { return cycle_; }

 private:
  void note_position(std::uint64_t steps) {
    std::uint64_t holds = 0;
    for (std::size_t k = 0; k < formula_.states.size(); ++k) {
      if (is_true(formula_.states[k], core_)) holds |= std::uint64_t{1} << k;
    }
    states_.push_back(holds);
    steps_.push_back(steps);
  }
  bool take(const LassoStep& step) {
    const rt::State before = core_.snapshot();
    const std::uint64_t count = core_.candidate_count();
    for (std::uint64_t k = 0; k < count; ++k) {
      if (graph_.label_of(core_, core_.candidate(k)) != step.label) continue;
      if (core_.fire(k) && graph_.find(core_) == step.state) {
        // The position is that of the state before.
        const rt::State after = core_.snapshot();
        if (!core_.restore(before)) return false;
        note_position(happens(formula_, graph_.labels(), step.label));
        choices_.push_back(k);
        labels_.push_back(step.label);
        return core_.restore(after);
      }
      if (!core_.restore(before)) return false;
    }
    return false;
  }
  // The labels of the state's steps that end in no error.
  void note_possible() {
    std::set<std::uint32_t>& labels = possible_.emplace_back();
    const rt::State before = core_.snapshot();
    const std::uint64_t count = core_.candidate_count();
    for (std::uint64_t k = 0; k < count; ++k) {
      const std::uint32_t label = graph_.label_of(core_, core_.candidate(k));
      if (core_.fire(k)) labels.insert(label);
      (void)core_.restore(before);
    }
  }

  const Formula& formula_;
  rt::StateGraph& graph_;
  rt::Core core_;
  std::vector<std::uint64_t> choices_, states_, steps_;
  std::vector<std::uint32_t> labels_;              // of the choices
  std::vector<std::set<std::uint32_t>> possible_;  // by position of the cycle
  std::size_t cycle_ = 0;
};

class LivenessDecision {
 public:
  LivenessDecision(const Formula& formula, const rt::Image& image, const LivenessOptions& options)
      : formula_(formula),
        image_(image),
        options_(options),
        graph_(image, {.bytes = options.megabytes * kMegabyte,
                       .is_stopped = [this] { return is_stopped(); },
                       .unread_cells = options.unread_cells,
                       .predicates = predicates_of(formula.states)}) {}

  LivenessResult run() {
    Result<Automaton> automaton = make_automaton(formula_, RunsOf::Negation);
    if (!automaton) return unknown(automaton.error());
    automaton_ = std::move(*automaton);
    result_.automaton_states = static_cast<std::uint32_t>(automaton_.edges.size());
    if (!graph_.initialize()) return unknown("the initial state could not be entered");
    // True of every run whatsoever.
    if (automaton_.is_empty()) {
      if (options_.add_state) {
        const rt::ExploreEnd end = graph_.grow(kMostStates);
        count();
        if (end != rt::ExploreEnd::Complete) return unknown(reason_of(end));
      }
      return holds();
    }
    for (std::uint64_t wanted = kStatesOfFirstRound;; wanted *= kGrowthOfRounds) {
      const rt::ExploreEnd end = graph_.grow(static_cast<std::uint32_t>(std::min(wanted, kMostStates)));
      count();
      if (!has_room()) return unknown("the memory does not suffice");
      const Product product(graph_, automaton_, formula_);
      if (is_invariant_of_past(formula_)) {
        const BadPrefix prefix = find_bad_prefix(product, options_.cancellation);
        result_.nodes = prefix.visited;
        if (prefix.end == BadPrefix::End::Stopped) return unknown(reason_of(rt::ExploreEnd::Stopped));
        if (prefix.end == BadPrefix::End::Found) return violated(prefix);
        if (end != rt::ExploreEnd::Complete) return unknown(reason_of(end));
        if (graph_.is_complete()) break;
        continue;
      }
      const AcceptingComponent found = find_accepting_component(product, options_.fairness, options_.cancellation);
      result_.nodes = found.visited;
      if (found.end == AcceptingComponent::End::Stopped) return unknown(reason_of(rt::ExploreEnd::Stopped));
      if (found.end == AcceptingComponent::End::Found) return violated(find_lasso(product, found, options_.fairness));
      if (end != rt::ExploreEnd::Complete) return unknown(reason_of(end));
      if (graph_.is_complete()) break;
    }
    return holds();
  }

 private:
  LivenessResult holds() {
    result_.outcome = Outcome::Holds;
    if (options_.add_state) graph_.each_state(options_.add_state);
    return std::move(result_);
  }
  [[nodiscard]] bool is_stopped() const {
    if (options_.report) options_.report("exploring", graph_.states(), "states");
    return options_.cancellation.is_over() || soon_.is_over();
  }
  void count() {
    result_.states = graph_.states();
    result_.steps = graph_.steps();
    result_.has_errors = graph_.errors() != 0;
  }
  [[nodiscard]] bool has_room() const {
    const std::size_t nodes = std::size_t{graph_.states()} * automaton_.edges.size();
    return Product::fits(graph_.states(), automaton_) &&
           graph_.bytes() + nodes * AcceptingComponent::kBytesPerNode <= options_.megabytes * kMegabyte;
  }
  std::string reason_of(rt::ExploreEnd end) {
    result_.is_out_of_time = end != rt::ExploreEnd::Memory;
    if (end == rt::ExploreEnd::Memory) return "the memory does not suffice";
    return options_.cancellation.is_cancelled() ? "interrupted" : "the time is over";
  }
  LivenessResult unknown(const std::string& reason) {
    result_.outcome = Outcome::Unknown;
    result_.reason = reason;
    return std::move(result_);
  }
  LivenessResult violated(const BadPrefix& prefix) {
    LassoReplay replay(formula_, image_, graph_);
    if (!replay.run(prefix) || !replay.violates_at_last())
      return unknown("a run that was found could not be confirmed");
    result_.outcome = Outcome::Violated;
    result_.choices = replay.choices();
    result_.cycle = result_.choices.size();
    result_.is_prefix = true;
    result_.has_ended = prefix.repeats != 0;
    return std::move(result_);
  }
  LivenessResult violated(const Lasso& lasso) {
    LassoReplay replay(formula_, image_, graph_);
    if (!replay.run(lasso) || !replay.violates() || !replay.is_fair(options_.fairness))
      return unknown("a run that was found could not be confirmed");
    result_.outcome = Outcome::Violated;
    result_.choices = replay.choices();
    result_.cycle = replay.cycle();
    result_.turns = replay.turns(options_.fairness);
    find_helpful_fairness(lasso);
    return std::move(result_);
  }
  // Does a stronger fairness make it true? Answered only if the graph is small or complete, and soon.
  void find_helpful_fairness(const Lasso& lasso) {
    // A run that ends is fair.
    const std::vector<Fairness> stronger = stronger_than(options_.fairness);
    if (lasso.cycle.empty() || stronger.empty()) return;
    soon_ = options_.cancellation.within(kSecondsOfRemark);
    if (!graph_.is_complete() && graph_.grow(kStatesOfRemark) != rt::ExploreEnd::Complete) return;
    if (!graph_.is_complete() || !has_room()) return;
    const Product product(graph_, automaton_, formula_);
    for (const Fairness& fairness : stronger) {
      const AcceptingComponent found = find_accepting_component(product, fairness, soon_);
      if (found.end == AcceptingComponent::End::Stopped) return;
      if (found.end == AcceptingComponent::End::None) {
        result_.holds_under = fairness;
        return;
      }
    }
  }

  const Formula& formula_;
  const rt::Image& image_;
  const LivenessOptions& options_;
  CancellationToken soon_;
  rt::StateGraph graph_;
  Automaton automaton_;
  LivenessResult result_;
};

}  // namespace

LivenessResult decide_liveness(const Formula& formula, const rt::Image& image, const LivenessOptions& options) {
  return LivenessDecision(formula, image, options).run();
}

}  // namespace bip::verify
