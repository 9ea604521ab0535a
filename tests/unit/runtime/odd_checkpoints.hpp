// Checkpoints whose bytes are cut off or odd: refused, or a state from which steps can be taken, and never more.
#pragma once
#include <catch2/catch.hpp>

#include <string>
#include <string_view>

#include "bip/prng.hpp"
#include "runtime/distributed/checkpoint.hpp"

namespace bip::testing {

/// Reads the checkpoint's bytes, which print_checkpoint made of a restored core, cut off at each place and with another
/// byte at each. Returns how many of the latter were states.
inline std::size_t check_odd_checkpoints(const rt::Image& image, const rt::Core& core, const rt::Checkpoint& checkpoint,
                                         std::uint64_t seed) {
  constexpr int kSteps = 5;
  const std::string bytes = rt::print_checkpoint(core, checkpoint);
  rt::Prng draws(seed);
  std::size_t states = 0;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    rt::Checkpoint cut = checkpoint;
    CHECK_FALSE(rt::read_checkpoint(core, std::string_view(bytes).substr(0, size), cut).empty());
    std::string odd = bytes;
    odd[size] = static_cast<char>(draws.below(256));
    rt::Checkpoint other = checkpoint;
    rt::Core from_odd(image);
    REQUIRE(from_odd.initialize());
    if (!rt::read_checkpoint(core, odd, other).empty() || !from_odd.restore(other.state)) continue;
    ++states;
    for (int step = 0; step < kSteps && from_odd.candidate_count() != 0; ++step) {
      const rt::EnabledSet::Position at = from_odd.position(0);
      if (!(from_odd.is_timed() ? from_odd.time().take(at) : from_odd.take(at))) break;
    }
  }
  return states;
}

}  // namespace bip::testing
