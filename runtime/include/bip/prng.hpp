// The random numbers of the policies: xoshiro256++ (Blackman and Vigna, "Scrambled linear pseudorandom number
// generators", 2021) seeded by SplitMix64, and an exact uniform choice below n (Lemire, "Fast random integer generation
// in an interval", 2019). Part of what a trace depends on: semantics.md fixes it, tests/unit/runtime pins its values.
#pragma once
#include <bit>
#include <cstdint>

#include "bip/contract.hpp"

namespace bip::rt {

/// Uniform in [0, n), n > 0, exactly: the multiply-shift with rejection, over the full 64 bits of generator.next().
template <class Generator>
std::uint64_t below(Generator& generator, std::uint64_t n) {
  BIP_ASSERT(n != 0, "a number below 0");
  __extension__ using Wide = unsigned __int128;
  Wide product = static_cast<Wide>(generator.next()) * n;
  if (static_cast<std::uint64_t>(product) < n) {
    const std::uint64_t threshold = (0 - n) % n;
    while (static_cast<std::uint64_t>(product) < threshold) {
      product = static_cast<Wide>(generator.next()) * n;
    }
  }
  return static_cast<std::uint64_t>(product >> 64);
}

class Prng {
 public:
  explicit Prng(std::uint64_t seed = 0) {
    for (std::uint64_t& word : words_) {
      seed += 0x9e3779b97f4a7c15u;
      std::uint64_t z = seed;
      z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
      z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
      word = z ^ (z >> 31);
    }
  }

  std::uint64_t next() {
    const std::uint64_t result = std::rotl(words_[0] + words_[3], 23) + words_[0];
    const std::uint64_t t = words_[1] << 17;
    words_[2] ^= words_[0];
    words_[3] ^= words_[1];
    words_[1] ^= words_[2];
    words_[0] ^= words_[3];
    words_[2] ^= t;
    words_[3] = std::rotl(words_[3], 45);
    return result;
  }

  /// Uniform in [0, n), n > 0, exactly.
  std::uint64_t below(std::uint64_t n) { return rt::below(*this, n); }

  /// Uniform in [0, 1): a multiple of 2^-53.
  double share() { return static_cast<double>(next() >> 11) * 0x1p-53; }

  friend bool operator==(const Prng&, const Prng&) = default;

 private:
  std::uint64_t words_[4];
};

}  // namespace bip::rt
