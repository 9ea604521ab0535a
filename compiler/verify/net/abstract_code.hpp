// Guards and actions over values that may be unknown: what is known of the result is known for every value of the rest.
//
// Exact for int, bool and string constants; float, FFI data, calls and faults give unknown. Cost: the size of the
// code, plus a copy of the variables at an `if` whose condition is unknown.
#pragma once
#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "compiler/model/code_uses.hpp"

namespace bip::verify {

/// Int, Bool (0, 1) or String (row of CodeTable::strings, -1: "" where no row is).
struct AbstractValue {
  bool is_known = false;
  std::int32_t value = 0;
  friend auto operator<=>(const AbstractValue&, const AbstractValue&) = default;
};
[[nodiscard]] inline AbstractValue known(std::int32_t value) { return {true, value}; }

/// Variables outside the spans are unknown.
[[nodiscard]] AbstractValue evaluate(const CodeTable& code, ExprId expr, std::span<const AbstractValue> self,
                                     std::span<const AbstractValue> bind);

/// Runs the body over Self. What is stored into Bind is ignored.
void execute(const CodeTable& code, StmtId body, std::vector<AbstractValue>& self);
/// Over both: a transfer.
void execute(const CodeTable& code, StmtId body, std::vector<AbstractValue>& self, std::vector<AbstractValue>& bind);

/// True, also for no guard at all, if the guard is true whatever its variables are.
[[nodiscard]] bool is_always_true(const CodeTable& code, ExprId guard);

using model::for_each_assigned;
using model::for_each_expr;
using model::for_each_stmt;

}  // namespace bip::verify
