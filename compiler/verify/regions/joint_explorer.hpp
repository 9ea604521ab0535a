// Which local states of two or three components occur together: all steps of these, everything else being free to do
// what it likes. What is not found together occurs in no reachable state.
//
// The values of each component are divided at the constants of these components alone, so the states are few, whatever
// the size of the system; components that are not followed count by the regions that their data lie in, so steps with
// many of them are one. Local reasoning about neighbourhoods: K. Namjoshi, Symmetry and Completeness in the Analysis of
// Parameterized Systems (2007). Cost: the steps between tuples of local states.
#pragma once
#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "compiler/verify/regions/region_step.hpp"
#include "compiler/verify/solver/cancellation.hpp"

namespace bip::verify {

class JointExplorer {
 public:
  static constexpr u32 kMostFollowed = 3, kMostLocalStates = 256;
  /// By followed component the number of its local state; 0 for those beyond.
  using Tuple = std::array<std::uint8_t, kMostFollowed>;

  /// `follows`: by atom type and variable. `net` must outlive the explorer.
  JointExplorer(const RegionNet& net, const std::vector<std::vector<std::uint8_t>>& follows);

  /// Explores these two or three components. False: there are too many states, or the time is over; then nothing below
  /// holds.
  [[nodiscard]] bool explore(const std::vector<u32>& atoms, std::size_t most, const CancellationToken& cancellation);
  [[nodiscard]] const std::vector<LocalSpace>& spaces() const { return spaces_; }
  [[nodiscard]] const std::vector<Tuple>& reached() const { return reached_; }

 private:
  using Pair = std::array<std::uint8_t, 2>;
  // Steps of two of the components, and what has been computed of them.
  struct Together {
    u32 first = 0, second = 0;  // rows of spaces_
    std::vector<RegionStep> steps;
    std::vector<u32> list_of;  // by local states: row of lists, or 0
    std::vector<u32> touched;
    std::vector<std::vector<Pair>> lists;
  };

  void collect_steps(const std::vector<u32>& atoms);
  bool reach(const Tuple& tuple);
  const std::vector<u32>& moves_alone(u32 space, u32 state);
  const std::vector<Pair>& moves_together(Together& together, u32 first, u32 second);
  void fire(const RegionStep& step, const Tuple& from, const std::function<void(const Tuple&)>& reach);

  const RegionNet& net_;
  const std::vector<std::vector<std::uint8_t>>& follows_;
  std::vector<LocalSpace> spaces_;
  std::vector<std::vector<RegionStep>> alone_;                       // by space: steps that no other one takes part in
  std::vector<std::vector<std::optional<std::vector<u32>>>> moves_;  // by space and state
  std::vector<Together> together_;
  std::vector<RegionStep> of_three_;
  std::vector<std::uint64_t> is_reached_;  // bits, by tuple
  std::vector<Tuple> reached_;
};

}  // namespace bip::verify
