// In which order boxes stand beside each other, so that those which nets join are near.
#pragma once
#include <cstdint>
#include <vector>

namespace bip::graph {

/// Returns the children in an order with short nets; `members` has the children of each net, sorted. Starts with the
/// given order and never ends with a worse one. Linear in the members per round, with a fixed number of rounds; small
/// sets are improved by moving one child at a time.
[[nodiscard]] std::vector<std::uint32_t> order_of_children(const std::vector<std::uint32_t>& children,
                                                           const std::vector<std::vector<std::uint32_t>>& members);

/// Returns 0 or 1 for each child of the order so that each net has children of both, the first on side 0; empty if
/// there is no such division, or if the nets of two children do not say it for all. Linear in the members.
[[nodiscard]] std::vector<std::uint32_t> sides_of_children(const std::vector<std::uint32_t>& order,
                                                           const std::vector<std::vector<std::uint32_t>>& members);

}  // namespace bip::graph
