// The local states of one component by regions of values: a marking, and for each variable that is followed one of the
// intervals into which constants divide its range; internal transitions are followed to their end, so a state is
// stable.
//
// What a step does to an interval is computed by the domain of intervals (interval_domain.hpp) and widened to regions:
// an over-approximation. Cost of a step: linear in the code of the component's transitions.
#pragma once
#include <unordered_map>
#include <utility>
#include <vector>

#include "compiler/verify/regions/region_net.hpp"

namespace bip::verify {

class LocalSpace {
 public:
  /// What a connector may write: variable and range.
  using Writes = std::vector<std::pair<u32, Range>>;

  /// `follows`: by variable. `net` must outlive the space.
  LocalSpace(const RegionNet& net, u32 atom, const RegionConstants& constants,
             const std::vector<std::uint8_t>& follows);

  [[nodiscard]] u32 atom() const { return atom_; }
  [[nodiscard]] u32 size() const { return static_cast<u32>(marking_of_.size()); }
  /// Regions and markings are too many to be numbered: the space is of no use.
  [[nodiscard]] bool is_too_large() const { return is_too_large_; }
  /// Returns the states that the component may be in at first; afterwards they have numbers.
  [[nodiscard]] std::vector<u32> initial();
  /// Returns the states that a transition of the port may lead to, if these values are written. Each once.
  [[nodiscard]] std::vector<u32> after(u32 state, u32 port, const Writes& writes);
  /// Do states tell the regions of the variable apart?
  [[nodiscard]] bool follows(u32 variable) const { return column_[variable] != kNone; }
  /// The range of a variable in a state.
  [[nodiscard]] const Range& range(u32 state, u32 variable) const;
  [[nodiscard]] const std::vector<u32>& marking(u32 state) const { return markings_[marking_of_[state]]; }
  [[nodiscard]] bool is_marked(u32 state, u32 place) const;
  [[nodiscard]] bool may_offer(u32 state, u32 port) const;
  /// Is the port enabled, whatever the values within the regions are?
  [[nodiscard]] bool surely_offers(u32 state, u32 port) const;
  /// Is there a value of every variable that is in both states?
  [[nodiscard]] bool overlaps(u32 state, const LocalSpace& other, u32 other_state) const;

 private:
  using Key = std::uint64_t;
  [[nodiscard]] IntervalPoint point_of(Key key) const;
  [[nodiscard]] bool leaves(const std::vector<u32>& marking, const Transition& t) const;
  [[nodiscard]] bool move_tokens(const std::vector<u32>& marking, const Transition& t, std::vector<u32>& next) const;
  u32 number_of_marking(const std::vector<u32>& marking);
  void add_boxes(u32 marking, const IntervalPoint& point, std::vector<Key>& keys) const;
  void settle(u32 marking, const IntervalPoint& point, std::vector<u32>& stable);
  u32 number_of(Key key);

  const RegionNet& net_;
  u32 atom_;
  const AtomType& type_;
  mutable IntervalDomain domain_;
  std::vector<Range> whole_;                 // by variable
  std::vector<u32> followed_;                // variables
  std::vector<u32> column_;                  // by variable: of followed_, or kNone
  std::vector<std::vector<Range>> regions_;  // by followed variable, ascending
  std::vector<std::vector<u32>> markings_;
  std::vector<u32> marking_of_;  // by state
  std::vector<Key> key_of_;
  std::vector<u32> region_of_;  // by state and followed variable
  std::unordered_map<Key, u32> number_;
  bool is_too_large_ = false;
  static constexpr u32 kNone = ~u32{0};
};

/// The intervals into which constants divide a range: each constant by itself, and what is between them.
[[nodiscard]] std::vector<Range> divide(const Range& range, const std::vector<std::int64_t>& constants);

}  // namespace bip::verify
