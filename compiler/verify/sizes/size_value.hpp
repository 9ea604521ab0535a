// What index code computes, for every size at once: a value over the size n and one position i, as far as it is linear
// (`i + 1`, `n - 1`), linear modulo n (`(i + 1) % n`), or a condition that has one truth at all sizes and positions.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "compiler/model/code.hpp"

namespace bip::verify {

struct SizeValue {
  enum class Kind : std::uint8_t { Linear, Circular, Truth, Unknown };  // Circular: a linear value modulo n
  Kind kind = Kind::Unknown;
  std::int64_t of_position = 0, of_size = 0, constant = 0;  // of_position * i + of_size * n + constant
  bool truth = false;

  [[nodiscard]] static SizeValue linear(std::int64_t of_position, std::int64_t of_size, std::int64_t constant) {
    return {Kind::Linear, of_position, of_size, constant, false};
  }
  [[nodiscard]] bool is_constant() const { return kind == Kind::Linear && of_position == 0 && of_size == 0; }
  /// `n + c`
  [[nodiscard]] bool is_from_end() const { return kind == Kind::Linear && of_position == 0 && of_size == 1; }
};

/// The positions and sizes in question: low <= i < n - high, n >= least.
struct SizeRange {
  std::int64_t low = 0, high = 0, least = 1;
};

/// Returns the value of the expression where the parameters and loop variables have the values `self`. Unknown is
/// always right.
[[nodiscard]] SizeValue evaluate_for_sizes(const CodeTable& code, ExprId expr, const std::vector<SizeValue>& self,
                                           const SizeRange& range);

}  // namespace bip::verify
