// Random systems of voters and candidates who count their votes, and properties about who may win, for proofs by
// counting.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace bip::verify::test {

struct QuorumNet {
  std::string text;
  std::vector<std::string> properties;
};
/// Returns interchangeable voters with two small numbers and one or two places, and candidates that ask them, one by
/// one, in pairs or all together, until a limit that is sometimes just enough for what a property says and sometimes
/// just too low. The same seed gives the same.
[[nodiscard]] QuorumNet quorum_net(std::uint64_t seed);

}  // namespace bip::verify::test
