// Runs in words: the steps, and what repeats for ever.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "runtime/include/bip/image.hpp"

namespace bip::library {

/// A run from the initial state, by the numbers of the candidates that are taken.
struct ShownRun {
  const std::vector<std::uint64_t>& choices;
  std::size_t cycle = 0;   // the choices from here on repeat
  bool has_ended = false;  // nothing repeats but the last state
};

/// Returns a line for each step, of a long stem and of a long cycle `max_lines`, and says where the cycle begins. The
/// image has its code.
[[nodiscard]] std::string steps_text(const rt::Image& image, const ShownRun& run, std::size_t max_lines);

}  // namespace bip::library
