// A step of an atom, together with the interaction that brought it where it is (split_by_history.hpp).
#pragma once
#include <compare>
#include <cstdint>

namespace bip::verify {

/// An atom at a place, with a history (a connector, or kNoHistory), and a connector that might move it next.
struct HistoryMove {
  static constexpr std::uint32_t kNoHistory = 0xffffffffu;
  std::uint32_t atom = 0, place = 0, history = kNoHistory, connector = 0;
  friend auto operator<=>(const HistoryMove&, const HistoryMove&) = default;
};

}  // namespace bip::verify
