// Properties of branching time: computation tree logic (Clarke, Emerson 1981) about conditions on states. `(branches
// F)` says that F is true at first. The words that ask for some run count steps that are possible for sure, those that
// ask for all runs all that may be; where no step leads anywhere, the state repeats.
#pragma once
#include "tools/certcheck/successors.hpp"

namespace certcheck {

class Branches {
 public:
  Branches(const Certificate& certificate, const Tree& claim)
      : states_(certificate.states.begin(), certificate.states.end()), formula_(claim.at(1)), of_(states_.size()) {
    add(formula_, 0);
  }

  /// The state whose steps follow; the system looks at it.
  void enter(const std::u32string& state, System& system) {
    now_ = row_of_state(state);
    for (const Tree& leaf : leaves_) {
      const expr holds = system.claim(leaf);
      if (!is(holds, true) && !is(holds, false))
        throw NotCheckable("a condition depends on values that are not followed");
      of_[now_].leaves.push_back(is(holds, true));
    }
  }
  /// A step that may be possible leads there; `is_clear`: and nowhere else.
  void lead(const Step& step, const std::u32string& to, bool is_clear) {
    const bool is_sure = is_clear && is(step.sure, true) && is(step.fault, false);
    of_[now_].after.push_back({row_of_state(to), is_sure});
    if (!is_sure) has_unsure_ = true;
  }
  /// With the state where runs begin.
  void check(const std::u32string& first) const {
    if (value(formula_, true)[row_of_state(first)]) return;
    if (has_unsure_) throw NotCheckable("it is not clear which steps are possible");
    throw Rejected("the claim is false at first");
  }

 private:
  using Set = std::vector<bool>;  // of states
  enum class Runs { All, Some };
  struct Edge {
    std::size_t to = 0;
    bool is_sure = false;
  };
  struct Listed {
    std::vector<bool> leaves;
    std::vector<Edge> after;
  };

  static bool is_branching(const Tree& e) {
    static const std::vector<Text> kWords{"all-next",  "all-until",  "all-release",
                                          "some-next", "some-until", "some-release"};
    return contains(kWords, e.head()) || !e.find(kWords).empty();
  }
  // Conditions on one state, as large as they are.
  void add(const Tree& e, std::size_t depth) {
    constexpr std::size_t kMostDepth = 1000;
    if (depth > kMostDepth) throw NotCheckable("the claim is nested too deeply");
    if (!is_branching(e)) {
      if (!contains(leaves_, e)) leaves_.push_back(e);
      return;
    }
    const Text op = e.head();
    const bool is_unary = op == "not" || op.ends_with("-next");
    const bool is_known = is_unary || op == "and" || op == "or" || op.ends_with("-until") || op.ends_with("-release");
    if (!is_known || e.items.size() != (is_unary ? 2 : 3))
      throw Rejected("the claim has an unknown form " + quoted(op));
    for (std::size_t k = 1; k < e.items.size(); ++k) add(e.items[k], depth + 1);
  }
  [[nodiscard]] std::size_t row_of_state(const std::u32string& state) const {
    return static_cast<std::size_t>(std::ranges::lower_bound(states_, state) - states_.begin());
  }

  // The states in which the formula is true for sure, or false for sure.
  [[nodiscard]] Set value(const Tree& e, bool is_true) const {
    Set set(of_.size());
    const auto leaf = std::find(leaves_.begin(), leaves_.end(), e);
    if (leaf != leaves_.end()) {
      const auto k = static_cast<std::size_t>(leaf - leaves_.begin());
      for (std::size_t s = 0; s < set.size(); ++s) set[s] = of_[s].leaves[k] == is_true;
      return set;
    }
    const Text op = e.head();
    if (op == "not") return value(e.at(1), !is_true);
    const Set a = value(e.at(1), is_true);
    const Runs runs = op.starts_with("some-") == is_true ? Runs::Some : Runs::All;
    if (op.ends_with("-next")) {
      for (std::size_t s = 0; s < set.size(); ++s) {
        const std::vector<std::size_t> after = successors(s, runs);
        const auto is_in = [&](std::size_t to) { return a[to]; };
        set[s] = runs == Runs::All ? std::ranges::all_of(after, is_in) : std::ranges::any_of(after, is_in);
      }
      return set;
    }
    const Set b = value(e.at(2), is_true);
    if (op == "and" || op == "or") {
      for (std::size_t s = 0; s < set.size(); ++s) set[s] = (op == "and") == is_true ? a[s] && b[s] : a[s] || b[s];
      return set;
    }
    // What is no until is a release, which is an until of all that is not so.
    if (op.ends_with("-until") == is_true) return until(a, b, runs, runs);
    set = until(complement(a), complement(b), runs == Runs::All ? Runs::Some : Runs::All, runs);
    return complement(set);
  }
  static Set complement(Set set) {
    set.flip();
    return set;
  }
  // Those that some run has for sure; or all that runs may have. A state that may have none repeats.
  [[nodiscard]] std::vector<std::size_t> successors(std::size_t state, Runs steps) const {
    const std::vector<Edge>& after = of_[state].after;
    std::vector<std::size_t> found;
    for (const Edge& edge : after)
      if (steps == Runs::All || edge.is_sure) found.push_back(edge.to);
    if (steps == Runs::All ? std::ranges::none_of(after, &Edge::is_sure) : after.empty()) found.push_back(state);
    return found;
  }
  // The least set with `goal` and what is in `through` with some or all of its steps into the set.
  [[nodiscard]] Set until(const Set& through, const Set& goal, Runs runs, Runs steps) const {
    std::vector<Rows> before(of_.size());
    std::vector<std::size_t> left(of_.size(), 1);
    Set set(of_.size());
    Rows todo;
    const auto add_state = [&](std::size_t s) {
      if (!set[s]) todo.push_back(s);
      set[s] = true;
    };
    for (std::size_t s = 0; s < of_.size(); ++s) {
      const std::vector<std::size_t> after = successors(s, steps);
      for (std::size_t to : after) before[to].push_back(s);
      if (runs == Runs::All) left[s] = after.size();
      if (goal[s] || (through[s] && left[s] == 0)) add_state(s);
    }
    while (!todo.empty()) {
      const std::size_t to = todo.back();
      todo.pop_back();
      for (std::size_t s : before[to])
        if ((runs == Runs::Some || --left[s] == 0) && through[s]) add_state(s);
    }
    return set;
  }

  const std::vector<std::u32string> states_;
  const Tree formula_;
  std::vector<Tree> leaves_;
  std::vector<Listed> of_;
  std::size_t now_ = 0;
  bool has_unsure_ = false;
};

}  // namespace certcheck
