// Values of constant expressions: component arguments, array sizes, indices. Self = the parameters and loop variables.
#pragma once
#include <optional>
#include <span>

#include "compiler/model/code.hpp"

namespace bip::model {

enum class Fault : std::uint8_t {
  None,
  DivisionByZero,
  DivisionOverflow,
  Call
};  // Call: C++ is not called before the run
struct Evaluated {
  Value value;
  Fault fault = Fault::None;
  ExprId at{};  // the row that faults
};
/// The expression reads nothing but Self. Its depth is bounded by the parser's.
[[nodiscard]] Evaluated evaluate(const CodeTable& code, ExprId expr, std::span<const Value> self);

}  // namespace bip::model
