// Properties of statements, generated from compiler/model/statements.def. Constant tables: every answer is one look-up.
#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "compiler/model/code.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip {

/// Which fields of Stmt a statement has, besides the value.
enum class StmtShape : std::uint8_t {
  StoresSelf,  // index: a variable of what owns the code
  StoresBind,  // index: a bound variable
  Chooses,     // then_body, else_body
  Evaluates    // none
};
enum class StmtValue : std::uint8_t { OfVariable, Condition, Call };

struct StmtInfo {
  const char* word;    // in .bsys
  const char* before;  // before the value, in text
  StmtShape shape;
  StmtValue value;
};
inline constexpr std::array kStatements{
#define BIP_STATEMENT_INFO(name, word, before, shape, value) StmtInfo{word, before, StmtShape::shape, StmtValue::value},
    BIP_STATEMENTS(BIP_STATEMENT_INFO)
#undef BIP_STATEMENT_INFO
};

[[nodiscard]] constexpr const StmtInfo& info_of(StmtOp op) {
  BIP_ASSERT(static_cast<std::size_t>(op) < kStatements.size(), "statement {}", static_cast<std::size_t>(op));
  return kStatements[static_cast<std::size_t>(op)];
}
[[nodiscard]] constexpr StmtShape shape_of(const Stmt& s) { return info_of(s.op).shape; }

/// Returns the statement with this word of .bsys; nothing: there is none.
[[nodiscard]] constexpr std::optional<StmtOp> stmt_op_of(std::string_view word) {
  for (std::size_t row = 0; row < kStatements.size(); ++row)
    if (word == kStatements[row].word) return static_cast<StmtOp>(row);
  return std::nullopt;
}

}  // namespace bip
