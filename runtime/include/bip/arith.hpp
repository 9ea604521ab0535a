// BIP's int arithmetic, defined once: 32-bit two's complement that wraps, division that truncates and may fault.
//
// Used by the interpreter and by emitted programs; the JIT generates the same operations. Header only, constexpr.
#pragma once
#include <cstdint>

#include "bip/image_tables.hpp"

namespace bip::rt {

constexpr std::int32_t wrap_add(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) + static_cast<std::uint32_t>(b));
}
constexpr std::int32_t wrap_sub(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b));
}
constexpr std::int32_t wrap_mul(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) * static_cast<std::uint32_t>(b));
}
constexpr std::int32_t wrap_neg(std::int32_t a) { return wrap_sub(0, a); }

/// The status of a / b or a % b at `site` if it faults, else 0.
constexpr std::int32_t division_status(std::int32_t a, std::int32_t b, std::uint32_t site) {
  if (b == 0) return fault_status(site, FaultKind::DivisionByZero);
  if (b == -1 && a == INT32_MIN) return fault_status(site, FaultKind::DivisionOverflow);
  return 0;
}

/// a / b and a % b, truncating; division_status(a, b) must be 0.
/// The quotient is taken in 64 bits: at -O2, g++ 12 takes the 32-bit wrap_neg(a) / b for -(a / b) when a / b is at
/// hand, which is wrong for INT32_MIN.
constexpr std::int32_t quotient(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::int64_t>(a) / b);
}
constexpr std::int32_t remainder(std::int32_t a, std::int32_t b) { return a % b; }

}  // namespace bip::rt
