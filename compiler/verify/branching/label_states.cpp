// See label_states.hpp.
#include "compiler/verify/branching/label_states.hpp"

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

Predecessors::Predecessors(const rt::StateGraph& graph) : first_(std::size_t{graph.states()} + 1, 0) {
  for (std::uint64_t step = 0; step < graph.steps(); ++step) ++first_[std::size_t{graph.target(step)} + 1];
  for (std::size_t state = 1; state < first_.size(); ++state) first_[state] += first_[state - 1];
  BIP_ASSERT(first_.back() == graph.steps(), "{} of {} steps have a target", first_.back(), graph.steps());
  sources_.resize(graph.steps());
  std::vector<std::uint64_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t state = 0; state < graph.expanded(); ++state) {
    for (std::uint64_t step = graph.first_step(state); step < graph.end_of_steps(state); ++step)
      sources_[next[graph.target(step)]++] = state;
  }
}

namespace {

class Labelling {
 public:
  Labelling(const BranchingFormula& formula, const rt::StateGraph& graph, const Predecessors& predecessors, Bound bound,
            const CancellationToken& cancellation)
      : formula_(formula),
        graph_(graph),
        predecessors_(predecessors),
        behind_(bound == Bound::Possibly),
        cancellation_(cancellation) {}

  std::optional<std::vector<StateSet>> run() {
    for (const BranchingNode& node : formula_.nodes) {
      sets_.push_back(label(node));
      BIP_ASSERT((!is_quantified(node.kind) && node.kind != BranchingKind::And && node.kind != BranchingKind::Or) ||
                     (node.a < sets_.size() - 1 && node.b < sets_.size() - 1),
                 "node {} stands before its operands {} and {}", sets_.size() - 1, node.a, node.b);
      if (is_over_) return std::nullopt;
    }
    return std::move(sets_);
  }

 private:
  StateSet label(const BranchingNode& node) {
    switch (node.kind) {
      case BranchingKind::Constant: {
        StateSet made(graph_.states());
        if (node.value) made.complement();
        return made;
      }
      case BranchingKind::State:
      case BranchingKind::NotState: return condition(node);
      case BranchingKind::And: {
        StateSet made = sets_[node.a];
        made.intersect(sets_[node.b]);
        return made;
      }
      case BranchingKind::Or: {
        StateSet made = sets_[node.a];
        made.unite(sets_[node.b]);
        return made;
      }
      case BranchingKind::Next: return next(node.quantifier, sets_[node.a]);
      case BranchingKind::Until:
        return until(
            node.quantifier, [&](std::uint32_t state) { return sets_[node.a].has(state); },
            [&](std::uint32_t state) { return sets_[node.b].has(state); });
      // A[a R b] is !E[!a U !b], E[a R b] is !A[!a U !b].
      case BranchingKind::Release: {
        const Quantifier dual = node.quantifier == Quantifier::All ? Quantifier::Some : Quantifier::All;
        StateSet made = until(
            dual, [&](std::uint32_t state) { return !sets_[node.a].has(state); },
            [&](std::uint32_t state) { return !sets_[node.b].has(state); });
        made.complement();
        return made;
      }
    }
    BIP_UNREACHABLE("a formula of no kind");
  }

  StateSet condition(const BranchingNode& node) {
    StateSet made(graph_.states());
    for (std::uint32_t state = 0; state < graph_.states(); ++state) {
      const bool is_expanded = state < graph_.expanded();
      const bool holds = is_expanded && (graph_.valuation(graph_.value(state)) >> node.row & 1) != 0;
      if (is_expanded ? holds == (node.kind == BranchingKind::State) : behind_) made.add(state);
    }
    return made;
  }
  StateSet next(Quantifier quantifier, const StateSet& operand) {
    const bool is_some = quantifier == Quantifier::Some;
    StateSet made(graph_.states());
    for (std::uint32_t state = 0; state < graph_.states() && !poll(); ++state) {
      bool holds = behind_;
      if (state < graph_.expanded()) {
        std::uint64_t step = graph_.first_step(state);
        const std::uint64_t end = graph_.end_of_steps(state);
        holds = step == end ? operand.has(state) : !is_some;
        for (; step < end && holds != is_some; ++step) {
          if (operand.has(graph_.target(step)) == is_some) holds = is_some;
        }
      }
      if (holds) made.add(state);
    }
    return made;
  }
  // The least fixpoint of X = goal || (through && some or all successors are in X): backwards from the goals. Of a
  // state that repeats, X reads X, so it is in X only as a goal.
  template <class Through, class Goal>
  StateSet until(Quantifier quantifier, const Through& through, const Goal& goal) {
    StateSet made(graph_.states());
    todo_.clear();
    for (std::uint32_t state = 0; state < graph_.states(); ++state) {
      if (!goal(state)) continue;
      made.add(state);
      todo_.push_back(state);
    }
    // Of steps that lead out of X.
    std::vector<std::uint32_t> outside;
    if (quantifier == Quantifier::All) {
      for (std::uint32_t state = 0; state < graph_.expanded(); ++state)
        outside.push_back(static_cast<std::uint32_t>(graph_.end_of_steps(state) - graph_.first_step(state)));
    }
    while (!todo_.empty() && !poll()) {
      const std::uint32_t state = todo_.back();
      todo_.pop_back();
      for (const std::uint32_t* source = predecessors_.begin(state); source != predecessors_.end(state); ++source) {
        BIP_ASSERT(quantifier != Quantifier::All || outside[*source] > 0,
                   "state {} has more steps into the set than steps", *source);
        const bool is_left = quantifier == Quantifier::All && --outside[*source] != 0;
        if (is_left || made.has(*source) || !through(*source)) continue;
        made.add(*source);
        todo_.push_back(*source);
      }
    }
    return made;
  }
  bool poll() {
    constexpr std::uint32_t kStatesPerPoll = 1u << 16;
    if (++polls_ % kStatesPerPoll == 0 && cancellation_.is_over()) is_over_ = true;
    return is_over_;
  }

  const BranchingFormula& formula_;
  const rt::StateGraph& graph_;
  const Predecessors& predecessors_;
  const bool behind_;  // what states without steps are taken to satisfy
  const CancellationToken& cancellation_;
  std::vector<StateSet> sets_;
  std::vector<std::uint32_t> todo_;
  std::uint32_t polls_ = 0;
  bool is_over_ = false;
};

}  // namespace

std::optional<std::vector<StateSet>> label_states(const BranchingFormula& formula, const rt::StateGraph& graph,
                                                  const Predecessors& predecessors, Bound bound,
                                                  const CancellationToken& cancellation) {
  return Labelling(formula, graph, predecessors, bound, cancellation).run();
}

std::size_t bytes_of_labels(const BranchingFormula& formula, const rt::StateGraph& graph) {
  // Predecessors while they are made, counters and states to do; a search for the run that explains the answer.
  constexpr std::size_t kBytesOfState = 8 + 8 + 4 + 4 + 20;
  const std::size_t states = graph.states();
  return states * kBytesOfState + graph.steps() * 4 + formula.nodes.size() * (states / 8 + 8) * 2;
}

}  // namespace bip::verify
