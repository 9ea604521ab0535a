// The local states of one component, whatever the others do: a least fixpoint.
//
// What a connector writes counts; that its guard may be false counts only where it writes to this component. Or
// connectors may write anything (region_net.hpp). Cost: a step for each state and each different thing that connectors
// write.
#pragma once
#include <optional>

#include "compiler/verify/regions/local_space.hpp"
#include "compiler/verify/solver/cancellation.hpp"

namespace bip::verify {

/// Returns a space that has exactly the reachable states; nothing: there are more than `most`, or the time is over.
[[nodiscard]] std::optional<LocalSpace> explore_alone(const RegionNet& net, u32 atom, const RegionConstants& constants,
                                                      const std::vector<std::uint8_t>& follows, u32 most,
                                                      const CancellationToken& cancellation);

}  // namespace bip::verify
