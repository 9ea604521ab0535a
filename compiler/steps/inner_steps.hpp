// Steps on arrays in an inner order. The source's order of a flat text may be random: then each interaction is a run of
// its own, whose operands are read from everywhere, and the list changes in so many orders that each is a shape. While
// a long run of compiled steps goes on, nothing else reads the core's arrays, so they may be in another order there
// (inner_order.hpp), in which the operands of neighbours are affine. The list still changes in the order of the
// source's interactions, so draws and traces do not depend on this.
#pragma once
#include "compiler/steps/deriver.hpp"

namespace bip::steps {

/// Fills steps.inner, and adds its shapes and operands to those of steps. Requires that each interaction that can fire
/// has a shape. Leaves steps as they are if the inner order is of no use; wherever it is possible, is for tests.
/// O(n log n).
enum class InnerOrders : std::uint8_t { WhereOfUse, WherePossible };
void derive_inner_steps(Deriver& deriver, const lower::LoweredSystem& lowered, InnerOrders where, lower::Steps& steps);

}  // namespace bip::steps
