// See explaining_run.hpp. A part of the formula has the value that is to be shown where the labels say so: all are
// true, or all are false, for negation stands before conditions only.
#include "compiler/verify/branching/explaining_run.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

class Explanation {
 public:
  Explanation(const BranchingFormula& formula, const rt::StateGraph& graph, const std::vector<StateSet>& labels,
              bool holds)
      : formula_(formula), graph_(graph), labels_(labels), holds_(holds) {}

  ExplainingRun run() {
    show(formula_.root, 0);
    if (!run_.repeats) run_.cycle = run_.steps.size();
    return std::move(run_);
  }

 private:
  [[nodiscard]] bool is_shown(std::uint32_t node, std::uint32_t state) const {
    BIP_ASSERT(node < labels_.size() && state < graph_.states(), "node {} of {} in state {} of {}", node,
               labels_.size(), state, graph_.states());
    return labels_[node].has(state) == holds_;
  }
  // Is one run enough to show the node's value?
  [[nodiscard]] bool asks_some(const BranchingNode& node) const {
    return (node.quantifier == Quantifier::Some) == holds_;
  }
  // Have both operands the value that is to be shown? Else one of them is enough.
  [[nodiscard]] bool needs_both(const BranchingNode& node) const { return (node.kind == BranchingKind::And) == holds_; }
  // Does a run have to be followed to show it?
  [[nodiscard]] bool has_run(std::uint32_t row, std::uint32_t state) const {
    const BranchingNode& node = formula_.nodes[row];
    if (is_quantified(node.kind)) return asks_some(node);
    if (node.kind != BranchingKind::And && node.kind != BranchingKind::Or) return false;
    if (needs_both(node)) return has_run(node.a, state) || has_run(node.b, state);
    return has_run(operand_to_show(node, state), state);
  }
  // Of operands of which one is enough: a condition before a word.
  [[nodiscard]] std::uint32_t operand_to_show(const BranchingNode& node, std::uint32_t state) const {
    BIP_ASSERT(is_shown(node.a, state) || is_shown(node.b, state),
               "neither operand of a node has its value in state {}", state);
    if (!is_shown(node.a, state)) return node.b;
    if (!is_shown(node.b, state)) return node.a;
    const BranchingKind kind = formula_.nodes[node.b].kind;
    return kind == BranchingKind::State || kind == BranchingKind::NotState ? node.b : node.a;
  }

  void show(std::uint32_t row, std::uint32_t state) {
    BIP_ASSERT(is_shown(row, state), "node {} has another value in state {}", row, state);
    const BranchingNode& node = formula_.nodes[row];
    switch (node.kind) {
      case BranchingKind::Constant:
      case BranchingKind::State:
      case BranchingKind::NotState: return;
      case BranchingKind::And:
      case BranchingKind::Or:
        if (needs_both(node)) show_both(node.a, node.b, state);
        else show(operand_to_show(node, state), state);
        return;
      case BranchingKind::Next:
      case BranchingKind::Until:
      case BranchingKind::Release: break;
    }
    if (!asks_some(node)) {
      run_.claims.push_back({run_.steps.size(), state, row});
      return;
    }
    if (node.kind == BranchingKind::Next) show(node.a, step_to(node.a, state));
    // Of a word for all runs that does not hold, its dual is shown: !(a U b) is !a R !b.
    else if ((node.kind == BranchingKind::Until) == holds_) reach(node.a, node.b, state);
    else stay(row, node.a, node.b, state);
  }
  // One run can show one of two that need a run; what needs none comes first.
  void show_both(std::uint32_t a, std::uint32_t b, std::uint32_t state) {
    if (has_run(a, state)) std::swap(a, b);
    if (!has_run(a, state)) show(a, state);
    show(b, state);
  }
  std::uint32_t step_to(std::uint32_t node, std::uint32_t state) {
    for (std::uint64_t step = graph_.first_step(state); step < graph_.end_of_steps(state); ++step) {
      if (!is_shown(node, graph_.target(step))) continue;
      run_.steps.push_back({graph_.label(step), graph_.target(step)});
      return graph_.target(step);
    }
    // No step leads anywhere: the state repeats.
    return state;
  }
  void reach(std::uint32_t through, std::uint32_t goal, std::uint32_t state) {
    const std::optional<std::uint32_t> found = search(
        state, Begin::AtState, [&](std::uint32_t at) { return is_shown(through, at); },
        [&](std::uint32_t at) { return is_shown(goal, at); });
    BIP_ENSURE(found, "a state that was counted on cannot be reached");
    show(goal, *found);
  }
  // In states of the word, in which `kept` is to be shown, until `end` is as well, or for ever.
  void stay(std::uint32_t word, std::uint32_t end, std::uint32_t kept, std::uint32_t state) {
    const auto is_inside = [&](std::uint32_t at) { return is_shown(word, at); };
    const std::optional<std::uint32_t> found = search(state, Begin::AtState, is_inside, [&](std::uint32_t at) {
      return is_inside(at) && (is_shown(end, at) || repeats(at));
    });
    if (found && is_shown(end, *found)) return show_both(kept, end, *found);
    run_.repeats = true;
    if (found) {
      run_.cycle = run_.steps.size();
      return;
    }
    // A walk inside comes to a state again.
    StateSet seen(graph_.states());
    std::uint32_t at = state;
    while (!seen.has(at)) {
      seen.add(at);
      std::uint64_t step = graph_.first_step(at);
      while (step < graph_.end_of_steps(at) && !is_inside(graph_.target(step))) ++step;
      BIP_ENSURE(step < graph_.end_of_steps(at), "state {} has no step inside", at);
      at = graph_.target(step);
    }
    const auto is_entry = [&](std::uint32_t other) { return other == at; };
    (void)search(state, Begin::AtState, is_inside, is_entry);
    run_.cycle = run_.steps.size();
    (void)search(at, Begin::BehindState, is_inside, is_entry);
  }
  [[nodiscard]] bool repeats(std::uint32_t state) const {
    return state < graph_.expanded() && graph_.first_step(state) == graph_.end_of_steps(state);
  }

  enum class Begin : std::uint8_t { AtState, BehindState };
  static constexpr std::uint64_t kNoStep = ~std::uint64_t{0};
  struct Way {
    std::uint32_t before = 0;
    std::uint64_t step = kNoStep;
  };
  // The fewest steps to a state that is wanted, through states that may be passed; these steps are taken.
  template <class MayPass, class IsWanted>
  std::optional<std::uint32_t> search(std::uint32_t from, Begin begin, const MayPass& may_pass,
                                      const IsWanted& is_wanted) {
    if (begin == Begin::AtState && is_wanted(from)) return from;
    std::vector<Way> ways(graph_.states());
    std::vector<std::uint32_t> queue{from};
    std::optional<std::uint32_t> found;
    for (std::size_t at = 0; at < queue.size() && !found; ++at) {
      const std::uint32_t state = queue[at];
      if (state >= graph_.expanded() || !may_pass(state)) continue;
      for (std::uint64_t step = graph_.first_step(state); step < graph_.end_of_steps(state) && !found; ++step) {
        const std::uint32_t to = graph_.target(step);
        if (ways[to].step != kNoStep || (to == from && begin == Begin::AtState)) continue;
        ways[to] = {state, step};
        queue.push_back(to);
        if (is_wanted(to)) found = to;
      }
    }
    if (!found) return std::nullopt;
    const auto first = static_cast<std::ptrdiff_t>(run_.steps.size());
    BIP_ASSERT(ways[*found].step != kNoStep, "state {} is found without a step", *found);
    std::uint32_t state = *found;
    do {
      run_.steps.push_back({graph_.label(ways[state].step), state});
      state = ways[state].before;
    } while (state != from);
    std::reverse(run_.steps.begin() + first, run_.steps.end());
    return found;
  }

  const BranchingFormula& formula_;
  const rt::StateGraph& graph_;
  const std::vector<StateSet>& labels_;
  const bool holds_;
  ExplainingRun run_;
};

}  // namespace

ExplainingRun explain(const BranchingFormula& formula, const rt::StateGraph& graph, const std::vector<StateSet>& labels,
                      bool holds) {
  return Explanation(formula, graph, labels, holds).run();
}

StatesFrom states_from(const rt::StateGraph& graph, std::uint32_t state) {
  StatesFrom found;
  StateSet seen(graph.states());
  std::vector<std::uint32_t> todo{state};
  seen.add(state);
  while (!todo.empty()) {
    const std::uint32_t at = todo.back();
    todo.pop_back();
    ++found.count;
    if (at >= graph.expanded()) {
      found.is_whole = false;
      continue;
    }
    for (std::uint64_t step = graph.first_step(at); step < graph.end_of_steps(at); ++step) {
      const std::uint32_t to = graph.target(step);
      if (seen.has(to)) continue;
      seen.add(to);
      todo.push_back(to);
    }
  }
  return found;
}

}  // namespace bip::verify
