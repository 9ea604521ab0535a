// An interaction of a plain rendezvous as components that are followed see it: these have local states, all others any
// values that they ever have.
#pragma once
#include <vector>

#include "compiler/verify/regions/local_space.hpp"

namespace bip::verify {

struct RegionStep {
  static constexpr u32 kNone = ~u32{0};
  struct Member {
    u32 space = 0;       // which of the spaces that are followed
    u32 port = 0;        // row of the atom type's ports
    u32 first_bind = 0;  // of the port's variables
  };
  u32 connector = 0;
  std::vector<Member> members;  // ascending by space
  std::vector<Range> binds;     // of those that are not followed
};

/// Returns the step of a connector for the components of these spaces, at least one of which takes part.
[[nodiscard]] RegionStep step_of(const RegionNet& net, u32 connector, const std::vector<u32>& atoms);

/// Evaluates the connector's guard, `up` and `down` over these ranges. False: the guard is true of none of them.
[[nodiscard]] bool transfer(const RegionNet& net, u32 connector, std::vector<Range>& binds);

/// What a member's variables get from a transfer that left these ranges.
[[nodiscard]] LocalSpace::Writes writes_to(const RegionNet& net, const RegionStep& step,
                                           const RegionStep::Member& member, u32 atom, const std::vector<Range>& binds);

}  // namespace bip::verify
