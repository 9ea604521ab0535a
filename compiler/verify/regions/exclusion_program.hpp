// Are local states of all components possible together, if some implications hold: "if component a is in one of these
// states, component b is in one of those"? Decided by a linear program, so an argument by counting is found: n
// processes at different levels, and only n - 1 levels.
//
// An unknown for each local state, of which each component has one:
//
//   sum over states of a component = 1      sum over `states` of an implication <= sum over its `implied`
//
// If this has no solution, nor have the components; the dual solution (Farkas 1902) is a multiplier m >= 0 for each
// implication. They are rounded to integers and count only if, with
//
//   weight[s] = sum of m over implications with s in `states` - sum of m over those with s in `implied`,
//
// the least weights of all components add up to more than 0: in a state of the system the sum is 0 at most.
//
// Components that are alike make unknowns that are alike: unknowns and implications are joined to classes, such that
// each member of a class has as many of each other class (colour refinement: M. Grohe, K. Kersting, M. Mladenov, E.
// Selman, Dimension Reduction via Colour Refinement, 2014). The program of the classes has a solution exactly if the
// whole one has, and its size does not grow with the number of like components. The proof is checked for the whole one.
#pragma once
#include <compare>
#include <cstdint>
#include <optional>
#include <tuple>
#include <vector>

#include "compiler/verify/solver/cancellation.hpp"

namespace bip::verify {

using u32 = std::uint32_t;

struct Implication {
  std::vector<u32> states;   // of one component, ascending
  std::vector<u32> implied;  // of another one, ascending
  u32 source = ~u32{0};      // why it holds, as the caller says
  u32 other = ~u32{0};       // the component of `implied`
  std::int64_t multiplier = 0;
  friend bool operator==(const Implication& a, const Implication& b) {
    return a.states == b.states && a.implied == b.implied;
  }
  friend auto operator<=>(const Implication& a, const Implication& b) {
    return std::tie(a.states, a.implied) <=> std::tie(b.states, b.implied);
  }
};

class ExclusionProgram {
 public:
  /// Adds a component with so many states. Returns the number of its first state.
  u32 add_component(u32 states);
  static constexpr u32 kNone = ~u32{0};
  /// Impossible states of a component: those of another one are, too, and the source of an implication says that one
  /// would need them; or, if there are none, the source says so by itself.
  struct Forbidden {
    std::vector<u32> states, others;
    u32 source = kNone;
  };

  /// This state is not possible, for a reason that the caller knows.
  void forbid(u32 state, u32 source = kNone);
  /// What is impossible, in the order in which it was found out.
  [[nodiscard]] const std::vector<Forbidden>& forbidden() const { return forbidden_; }
  [[nodiscard]] u32 component_of(u32 state) const { return component_of_[state]; }
  [[nodiscard]] std::vector<u32> impossible_states(u32 component) const;
  [[nodiscard]] bool is_possible(u32 state) const { return is_possible_[state] != 0; }
  [[nodiscard]] u32 size() const { return static_cast<u32>(component_of_.size()); }
  [[nodiscard]] std::size_t implications() const { return implications_.size(); }
  void add(Implication implication);

  struct Proof {
    std::vector<Implication> used;  // with multipliers above 0
    std::int64_t least = 0;         // sum of the least weights, above 0; of no implications: a component has no state
  };
  /// Returns a proof that no choice of states satisfies all implications; nothing: there is none of this form, or the
  /// time is over, or there are too many classes.
  [[nodiscard]] std::optional<Proof> refute(const CancellationToken& cancellation);

 private:
  struct Classes {
    std::vector<u32> of_state, of_component, of_implication;
    std::vector<u32> states, components, implications;  // by class: one of it
    std::vector<std::uint64_t> members;                 // by class of states
    std::vector<std::uint64_t> implication_members;     // by class of implications
  };
  [[nodiscard]] u32 end_of(u32 component) const {
    return component + 1 < first_.size() ? first_[component + 1] : size();
  }
  void propagate();
  void forbid_by_implications();
  void shorten(Implication& implication) const;
  [[nodiscard]] std::vector<u32> others_than(const std::vector<u32>& states) const;
  [[nodiscard]] Classes find_classes() const;
  [[nodiscard]] std::optional<Proof> round(const std::vector<double>& multipliers) const;
  [[nodiscard]] std::optional<std::int64_t> least_sum(const std::vector<std::int64_t>& multipliers) const;

  std::vector<u32> component_of_;  // by state
  std::vector<u32> first_;         // by component
  std::vector<std::uint8_t> is_possible_;
  std::vector<Implication> implications_;
  std::vector<Forbidden> forbidden_;
};

}  // namespace bip::verify
