// Is there a run of the product that is accepting and fair? A strong component says so.
//
// Strong components (Tarjan 1972) decide generalised Büchi acceptance and weak fairness: what a maximal component
// lacks, each of its parts lacks, too. Strong fairness is a Streett condition: states where something is possible that
// the component never takes are removed, and what remains is decomposed again (Emerson, Lei 1987). Cost: a step per
// edge of the product, for strong fairness times the depth of the decomposition. Memory: kBytesPerNode.
#pragma once
#include <cstdint>
#include <vector>

#include "compiler/verify/property/fairness.hpp"
#include "compiler/verify/liveness/product.hpp"
#include "compiler/verify/solver/cancellation.hpp"

namespace bip::verify {

struct AcceptingComponent {
  enum class End : std::uint8_t { Found, None, Stopped } end = End::None;
  static constexpr std::size_t kBytesPerNode = 20;
  std::vector<Product::Node> region;  // by node; Found: those of `component` are the component
  Product::Node component = 0;
  std::uint64_t visited = 0;  // nodes
};

/// Searches the nodes that runs reach. Stopped: the token is over.
[[nodiscard]] AcceptingComponent find_accepting_component(const Product& product, const Fairness& fairness,
                                                          const CancellationToken& cancellation);

}  // namespace bip::verify
