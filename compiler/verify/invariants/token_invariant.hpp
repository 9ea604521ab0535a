// Invariants about the modes of a net: traps, place invariants and state-machine components.
#pragma once
#include <compare>
#include <cstdint>
#include <vector>

namespace bip::verify {

/// Trap: at least one of the modes is marked. OneToken: exactly one (a state-machine component). Sum: the weights of
/// the marked modes add up to the total (a place invariant).
enum class InvariantKind : std::uint8_t { Trap, OneToken, Sum };
struct TokenInvariant {
  InvariantKind kind = InvariantKind::Trap;
  std::vector<std::uint32_t> modes;        // sorted
  std::vector<std::int64_t> weights = {};  // Sum: by row of modes, not 0; negative only of atoms with many modes
  std::int64_t total = 1;                  // Sum
  friend auto operator<=>(const TokenInvariant&, const TokenInvariant&) = default;
};

[[nodiscard]] inline std::int64_t weight_of(const TokenInvariant& invariant, std::size_t row) {
  return invariant.weights.empty() ? 1 : invariant.weights[row];
}

/// Does a marking (by mode: not 0 if marked) satisfy the invariant?
[[nodiscard]] inline bool is_satisfied(const TokenInvariant& invariant, const std::vector<std::uint8_t>& marked) {
  std::int64_t sum = 0;
  for (std::size_t k = 0; k < invariant.modes.size(); ++k) {
    if (marked[invariant.modes[k]] != 0) sum += weight_of(invariant, k);
  }
  return invariant.kind == InvariantKind::Trap ? sum >= 1 : sum == invariant.total;
}

}  // namespace bip::verify
