// Random systems of processes that pass levels one after the other and wait at each for those who came later or are
// behind (Peterson's filter lock, and what is nearly one), for proofs by regions of values.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace bip::verify::test {

struct LevelNet {
  std::string text;
  std::vector<std::string> properties;
};
/// Returns two or three processes with a level and a number that goes round, levels that remember who came last, guards
/// that mostly are those of the filter lock, and properties about who may be critical, who is remembered where and how
/// far numbers go. The same seed gives the same.
[[nodiscard]] LevelNet level_net(std::uint64_t seed);

}  // namespace bip::verify::test
