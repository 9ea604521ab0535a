// Random edits of a text: bytes changed, removed, inserted, doubled; words and lines moved between the sources.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace bip::fuzz {

/// SplitMix64: the same edits from the same seed on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next();
  /// 0 … n - 1; n > 0.
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(next() % n); }

 private:
  std::uint64_t state_;
};

/// One of `sources` after one edit to eight; at most a third longer than it was.
[[nodiscard]] std::string mutated(const std::vector<std::string>& sources, Random& random);

}  // namespace bip::fuzz
