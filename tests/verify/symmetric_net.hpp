// Random systems with arrays of equal components, and properties about them, for searches up to symmetry.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace bip::verify::test {

struct SymmetricNet {
  std::string text;
  std::vector<std::string> properties;
  std::vector<std::string> counted;  // properties with quantifiers over the clients
};
/// Returns clients of a desk: mostly equal, some with other arguments or with connectors of their own, so that a wrong
/// exchange of two changes what is reachable. Properties name none, some or all of them. The same seed gives the same.
[[nodiscard]] SymmetricNet symmetric_net(std::uint64_t seed);

}  // namespace bip::verify::test
