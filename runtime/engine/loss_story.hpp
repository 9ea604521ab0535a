// The report of a distributed run that lost nodes: which nodes, which components were at home there, which wait for
// them.
#pragma once
#include <string>
#include <vector>

#include "runtime/core/core.hpp"
#include "runtime/distributed/distribution.hpp"

namespace bip::rt {

/// Is no atom of the set at home on a lost node, nor the set coordinated there?
[[nodiscard]] bool is_whole(const Distribution& distribution, const std::vector<bool>& is_lost, u32 set);

/// Several lines. `core` is in the last state, as far as it is known. `why`: how the nodes ended; may be empty.
[[nodiscard]] std::string loss_story(const Core& core, const Distribution& distribution,
                                     const std::vector<bool>& is_lost, u64 steps, const std::string& why);

}  // namespace bip::rt
