// Local deadlocks: no component waits for ever while others move. From each listed state in which a component could
// take one of its ports, by itself, and is not at final places only, a step that it takes part in can be reached. Steps
// count that are possible for sure, and lead to one state that is known.
#pragma once
#include "tools/certcheck/successors.hpp"

namespace certcheck {

class Waits {
 public:
  Waits(const Model& model, const Certificate& certificate)
      : model_(model), states_(certificate.states.begin(), certificate.states.end()), of_(states_.size()) {}

  /// The state whose steps follow; the system looks at it.
  void enter(const std::u32string& state, const System& system) {
    now_ = row_of_state(state);
    for (std::size_t a = 0; a < model_.atoms.size(); ++a)
      if (!is(system.wants(a), false)) of_[now_].wants.insert(a);
  }
  /// A step, perhaps one that ends with an error.
  void take(const Step& step) {
    for (const auto& [node, is_in] : step.parts)
      if (is(step.sure, true) && is(is_in, true)) of_[now_].moves.insert(model_.atom_of_port[node]);
  }
  /// The step before leads there, and nowhere else.
  void lead(const Step& step, const std::u32string& to) {
    if (is(step.sure, true) && is(step.fault, false)) of_[row_of_state(to)].before.push_back(now_);
  }
  void check() const {
    for (std::size_t a = 0; a < model_.atoms.size(); ++a) {
      std::vector<bool> can(of_.size(), false);
      Rows todo;
      const auto reach = [&](std::size_t state) {
        if (!can[state]) todo.push_back(state);
        can[state] = true;
      };
      for (std::size_t state = 0; state < of_.size(); ++state)
        if (of_[state].moves.contains(a)) reach(state);
      while (!todo.empty()) {
        const std::size_t state = todo.back();
        todo.pop_back();
        for (std::size_t before : of_[state].before) reach(before);
      }
      for (std::size_t state = 0; state < of_.size(); ++state)
        if (!can[state] && of_[state].wants.contains(a))
          throw Rejected(quoted(model_.atoms[a].path) + " may wait for ever in a state that the certificate lists");
    }
  }

 private:
  struct Listed {
    std::set<std::size_t> wants, moves;  // atoms
    Rows before;                         // states
  };
  [[nodiscard]] std::size_t row_of_state(const std::u32string& state) const {
    return static_cast<std::size_t>(std::ranges::lower_bound(states_, state) - states_.begin());
  }

  const Model& model_;
  const std::vector<std::u32string> states_;
  std::vector<Listed> of_;
  std::size_t now_ = 0;
};

}  // namespace certcheck
