// Certificates by pairs of like components, of random systems: see pair_certificates.cpp.
#pragma once
#include <cstdint>

namespace bip::verify::test {

struct PairTally {
  unsigned long long systems = 0, proofs = 0, accepted = 0, forged = 0, changed = 0, same = 0, failed = 0;
};
/// Proves, changes and forges certificates of the system of that seed. `tells`: prints what is refused.
void check_pair_certificates(std::uint64_t seed, bool tells, PairTally& tally);

}  // namespace bip::verify::test
