// See decide_branching.hpp.
#include "compiler/verify/branching/decide_branching.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "compiler/verify/branching/explaining_run.hpp"
#include "compiler/verify/branching/label_states.hpp"
#include "compiler/verify/liveness/graph_rounds.hpp"
#include "compiler/verify/property/expression.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

class BranchingDecision {
 public:
  BranchingDecision(const BranchingFormula& formula, const rt::Image& image, const LivenessOptions& options)
      : formula_(formula),
        image_(image),
        options_(options),
        graph_(image, {.bytes = options.megabytes * kMegabyte,
                       .is_stopped = [this] { return is_stopped(); },
                       .unread_cells = options.unread_cells,
                       .predicates = predicates_of(formula.states)}) {}

  BranchingResult run() {
    if (!graph_.initialize()) return unknown("the initial state could not be entered");
    for (std::uint64_t wanted = kStatesOfFirstRound;; wanted *= kGrowthOfRounds) {
      const rt::ExploreEnd end = graph_.grow(static_cast<std::uint32_t>(std::min(wanted, kMostStates)));
      result_.states = graph_.states();
      result_.steps = graph_.steps();
      result_.is_complete = graph_.is_complete();
      result_.has_errors = graph_.errors() != 0;
      if (end == rt::ExploreEnd::Stopped) return unknown(reason_of_stop());
      if (graph_.bytes() + bytes_of_labels(formula_, graph_) > options_.megabytes * kMegabyte)
        return unknown("the memory does not suffice");
      const Predecessors predecessors(graph_);
      std::optional<std::vector<StateSet>> labels = bound(predecessors, Bound::Surely);
      if (!labels) return unknown(reason_of_stop());
      // The initial state is the first one.
      const std::uint32_t initial = 0;
      if (labels->at(formula_.root).has(initial)) return decided(Outcome::Holds, *labels);
      if (!graph_.is_complete()) labels = bound(predecessors, Bound::Possibly);
      if (!labels) return unknown(reason_of_stop());
      if (!labels->at(formula_.root).has(initial)) return decided(Outcome::Violated, *labels);
      if (end == rt::ExploreEnd::Memory) return unknown("the memory does not suffice");
    }
  }

 private:
  std::optional<std::vector<StateSet>> bound(const Predecessors& predecessors, Bound bound) const {
    return label_states(formula_, graph_, predecessors, bound, options_.cancellation);
  }
  [[nodiscard]] bool is_stopped() const {
    if (options_.report) options_.report("exploring", graph_.states(), "states");
    return options_.cancellation.is_over();
  }
  [[nodiscard]] std::string reason_of_stop() const {
    return options_.cancellation.is_cancelled() ? "interrupted" : "the time is over";
  }
  BranchingResult unknown(const std::string& reason) {
    result_.outcome = Outcome::Unknown;
    result_.reason = reason;
    return std::move(result_);
  }

  BranchingResult decided(Outcome outcome, const std::vector<StateSet>& labels) {
    const ExplainingRun run = explain(formula_, graph_, labels, outcome == Outcome::Holds);
    BIP_ASSERT(run.cycle <= run.steps.size() && labels.size() == formula_.nodes.size(),
               "step {} of {} begins the cycle", run.cycle, run.steps.size());
    if (!follow(run)) return unknown("a run that was found could not be confirmed");
    report(run, outcome);
    // A certificate lists all states, though the first ones have decided.
    if (outcome == Outcome::Holds && options_.add_state) {
      const rt::ExploreEnd end = graph_.grow(kMostStates);
      result_.states = graph_.states();
      result_.steps = graph_.steps();
      if (end == rt::ExploreEnd::Stopped) return unknown(reason_of_stop());
      if (end != rt::ExploreEnd::Complete) return unknown("the memory does not suffice");
      result_.is_complete = true;
      result_.has_errors = graph_.errors() != 0;
      graph_.each_state(options_.add_state);
    }
    result_.outcome = outcome;
    return std::move(result_);
  }
  void report(const ExplainingRun& run, Outcome outcome) {
    result_.cycle = run.cycle;
    result_.repeats = run.repeats;
    const std::uint32_t last = run.steps.empty() ? 0 : run.steps.back().state;
    result_.only_errors_follow =
        last < graph_.expanded() && graph_.first_step(last) == graph_.end_of_steps(last) && !graph_.is_end(last);
    for (const ClaimOfAllRuns& claim : run.claims) {
      const BranchingNode& node = formula_.nodes[claim.node];
      if (node.of_run.empty()) continue;
      const StatesFrom from = states_from(graph_, claim.state);
      result_.claims.push_back(
          {claim.position, (outcome == Outcome::Holds) != node.is_negation, node.of_run, from.count, from.is_whole});
    }
  }
  // Takes the run by a core. False: a step is not possible, or a condition has another value than in the graph.
  bool follow(const ExplainingRun& run) {
    rt::Core core(image_);
    if (!core.initialize() || !agrees(core, 0)) return false;
    for (const LassoStep& step : run.steps) {
      const rt::State before = core.snapshot();
      const std::uint64_t count = core.candidate_count();
      bool is_taken = false;
      for (std::uint64_t k = 0; k < count && !is_taken; ++k) {
        if (graph_.label_of(core, core.candidate(k)) != step.label) continue;
        is_taken = core.fire(k) && graph_.find(core) == step.state;
        if (is_taken) result_.choices.push_back(k);
        else if (!core.restore(before)) return false;
      }
      if (!is_taken || !agrees(core, step.state)) return false;
    }
    return true;
  }
  bool agrees(const rt::Core& core, std::uint32_t state) const {
    if (state >= graph_.expanded()) return true;
    const std::uint64_t holds = graph_.valuation(graph_.value(state));
    for (std::size_t k = 0; k < formula_.states.size(); ++k) {
      if (is_true(formula_.states[k], core) != ((holds >> k & 1) != 0)) return false;
    }
    return true;
  }

  const BranchingFormula& formula_;
  const rt::Image& image_;
  const LivenessOptions& options_;
  rt::StateGraph graph_;
  BranchingResult result_;
};

}  // namespace

BranchingResult decide_branching(const BranchingFormula& formula, const rt::Image& image,
                                 const LivenessOptions& options) {
  return BranchingDecision(formula, image, options).run();
}

}  // namespace bip::verify
