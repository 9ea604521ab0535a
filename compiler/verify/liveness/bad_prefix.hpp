// A finite run after which the formula is violated, whatever follows: how `always E` and `never E` fail if E looks
// back.
//
// Breadth first over the product, to the first node from which its automaton accepts everything. Where the state alone
// says so no step is needed, and a state all of whose steps end in errors counts, too. Cost: an edge of the product
// each, and 4 bytes a node.
#pragma once
#include <vector>

#include "compiler/verify/liveness/lasso.hpp"
#include "compiler/verify/solver/cancellation.hpp"

namespace bip::verify {

struct BadPrefix {
  enum class End : std::uint8_t { Found, None, Stopped } end = End::None;
  std::vector<LassoStep> steps;
  bool ends_with_step = false;  // the last step is what violates it; else the state after it
  std::uint32_t repeats = 0;    // of the last state, if the run ends: positions after it
  std::uint64_t visited = 0;    // nodes
};

[[nodiscard]] BadPrefix find_bad_prefix(const Product& product, const CancellationToken& cancellation);

}  // namespace bip::verify
