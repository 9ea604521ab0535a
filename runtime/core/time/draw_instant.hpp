// Random instants: uniform in an interval, exponential past its begin if it has no end.
#pragma once
#include <algorithm>

#include "bip/assert.hpp"
#include "bip/prng.hpp"
#include "runtime/core/time/interval.hpp"

namespace bip::rt {

/// Returns an instant in [first, last], each with the same probability; past `first` exponential with the mean if
/// there is no last (kForever). Draws nothing if only one is possible. The exponential is von Neumann's ("Various
/// techniques used in connection with random digits", 1951): comparisons of uniform numbers, no logarithm, so that
/// every machine draws the same.
[[nodiscard]] inline i64 draw_instant(Prng& prng, i64 first, i64 last, i64 mean) {
  BIP_ASSERT(first <= last && mean > 0, "an instant from {} to {}", first, last);
  if (first == last) return first;
  if (last != kForever) return first + static_cast<i64>(prng.below(static_cast<std::uint64_t>(last - first) + 1));
  for (i64 whole = 0;; ++whole) {
    const std::uint64_t start = prng.next();
    std::uint64_t before = start;
    std::uint64_t run = 1;
    for (std::uint64_t u = prng.next(); u <= before; u = prng.next()) {
      before = u;
      ++run;
    }
    if (run % 2 == 0) continue;
    const auto part = static_cast<i64>(static_cast<Int128>(start) * mean >> 64);
    return std::min(first + whole * mean + part, kForever - 1);
  }
}

}  // namespace bip::rt
