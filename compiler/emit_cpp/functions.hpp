// Emits one C++ function per code unit.
#pragma once
#include <cstdint>
#include <vector>

#include "compiler/emit_cpp/ffi_text.hpp"
#include "compiler/emit_cpp/writer.hpp"
#include "compiler/lower/lower.hpp"
#include "compiler/lower/unit_names.hpp"
#include "compiler/system/system.hpp"

namespace bip::emit_cpp {

/// Writes the functions of all units, in their order.
void emit_functions(const lower::LoweredSystem& lowered, CppWriter& out);

/// Writes the function of a unit once more, on cells: `self` has its variables at that distance.
void emit_on_cells(const lower::LoweredSystem& lowered, std::uint32_t unit, std::uint32_t distance, CppWriter& out);

/// Names for the variables of one function: unique, and nothing that C++ has taken.
class LocalNames {
 public:
  LocalNames();
  [[nodiscard]] std::string make(std::string_view name);

 private:
  lower::UniqueNames names_;
};

/// Which expressions can fault: true for a row if a division is below it or is itself.
class FaultInfo {
 public:
  explicit FaultInfo(const lower::LoweredSystem& lowered)
      : lowered_(lowered), known_(lowered.system->code.exprs.size(), 0) {}
  [[nodiscard]] bool can_fault(ExprId id);
  /// True if the expression calls C++, which may change what its neighbours read.
  [[nodiscard]] bool calls(ExprId id) const;

 private:
  const lower::LoweredSystem& lowered_;
  std::vector<std::uint8_t> known_;  // 0 not looked at, 1 no, 2 yes
};

/// A variable as one function sees it.
struct Local {
  std::string name;
  Type type = Type::Int;
  std::uint32_t index = rt::kNone;  // row in Self or Bind; kNone: not used
  bool written = false;
};

/// What the text of expressions needs to know of the function around them.
struct ExprContext {
  const lower::LoweredSystem& lowered;
  FaultInfo& faults;
  LocalNames& names;
  const FfiNames& ffi;
  const std::vector<Local>& self_locals;  // by row in Self
  const std::vector<Local>& bind_locals;
};

/// The expression in C++, parenthesised where the precedence or a reader asks for it.
[[nodiscard]] std::string expr_text(ExprContext& context, ExprId id);

}  // namespace bip::emit_cpp
