// A neighbourhood: the components that the property names, and one or two beside them. Its steps by who takes part, and
// what those beside do without the named ones: the same in all cases.
#pragma once
#include <span>
#include <vector>

#include "compiler/verify/liveness/neighbourhood_steps.hpp"

namespace bip::verify {

/// A step in which some component of a neighbourhood takes part.
struct FollowedStep {
  struct Seat {
    u32 atom = 0;
    bool is_named = false;
    u32 row = 0;  // among the named components, or those beside
  };
  u32 step = 0;
  std::vector<Seat> seats;  // ascending by component
  bool has_named = false, has_beside = false;
  bool is_whole = false;  // no component outside takes part
};

class Neighbourhood {
 public:
  /// A step without the named components.
  struct Move {
    u32 step = 0, to = 0;  // `to`: a combination of local states of those beside
  };
  /// `named`, `beside`: ascending, no component in both, with spaces.
  Neighbourhood(NeighbourhoodSteps& steps, const std::vector<u32>& named, const std::vector<u32>& beside,
                const CancellationToken& cancellation);

  /// False: combinations or moves are too many, or the time is over; then width(), moves() and with() do not hold.
  [[nodiscard]] bool is_complete() const { return is_complete_; }
  /// All components, ascending.
  [[nodiscard]] const std::vector<u32>& atoms() const { return atoms_; }
  /// Their steps, ascending.
  [[nodiscard]] const std::vector<FollowedStep>& steps() const { return steps_; }
  /// The row among them of a step, if it is whole; null: it is not, or is none of them.
  [[nodiscard]] const FollowedStep* find_whole(u32 step) const;

  /// Combinations of local states of those beside.
  [[nodiscard]] u32 width() const { return width_; }
  [[nodiscard]] std::span<const Move> moves(u32 combination) const {
    return std::span(moves_).subspan(first_[combination], first_[combination + 1] - first_[combination]);
  }
  /// Who takes part, while the named components are in these states and those beside in this combination of states.
  [[nodiscard]] NeighbourhoodSteps::Members members_of(const FollowedStep& step, const std::vector<u32>& named,
                                                       u32 combination) const;
  /// Enters what a move of the step does into both.
  void apply(const FollowedStep& step, const NeighbourhoodSteps::Move& move, std::vector<u32>& named,
             u32& combination) const;

 private:
  void find_steps(NeighbourhoodSteps& steps, const std::vector<u32>& named, const std::vector<u32>& beside);
  bool find_moves(NeighbourhoodSteps& steps, const CancellationToken& cancellation);
  // The local state of one of those beside, by row; and the combination in which it has another one.
  [[nodiscard]] u32 state_of(u32 row, u32 combination) const { return combination / strides_[row] % sizes_[row]; }
  [[nodiscard]] u32 with(u32 row, u32 state, u32 combination) const {
    return combination + (state - state_of(row, combination)) * strides_[row];
  }

  std::vector<u32> atoms_;
  std::vector<FollowedStep> steps_;
  std::vector<u32> sizes_, strides_;  // of those beside
  u32 width_ = 1;
  std::vector<u32> first_;  // by combination
  std::vector<Move> moves_;
  bool is_complete_ = false;
};

/// Calls `see(named, combination)` for each pair that the step may lead to from these.
template <class See>
void for_each_move(NeighbourhoodSteps& steps, const Neighbourhood& neighbourhood, const FollowedStep& step,
                   const std::vector<u32>& named, u32 combination, const See& see) {
  const NeighbourhoodSteps::Members members = neighbourhood.members_of(step, named, combination);
  for (const NeighbourhoodSteps::Move& move : steps.moves(step.step, members)) {
    std::vector<u32> next = named;
    u32 to = combination;
    neighbourhood.apply(step, move, next, to);
    see(next, to);
  }
}

}  // namespace bip::verify
