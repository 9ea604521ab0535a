// What the printer, the reader and the validator of .bsys share: its words, its limits, and the variables that a piece
// of code sees (its scope), by which loads and stores get names and types.
//
// Internal to system/. Scopes are built once a type or a priority; building one costs the number of its variables.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/model/operators.hpp"
#include "compiler/system/system.hpp"

namespace bip::system::text {

/// Nesting of expressions, statements and define groups that every stage must bear. The reader refuses more.
inline constexpr std::uint32_t kMaxCodeDepth = 2000;
/// The same in parentheses: an `if` with its `then` opens two, the rows around the code a few more.
inline constexpr std::uint32_t kMaxParentheses = 2 * kMaxCodeDepth + 16;

[[nodiscard]] const char* word_of(Type type);
[[nodiscard]] std::optional<Type> type_of(std::string_view word);
[[nodiscard]] const char* word_of(InvariantScope scope);
[[nodiscard]] std::optional<InvariantScope> invariant_scope_of(std::string_view word);
/// Returns the operator of a word (OperatorInfo::word); constants, loads and calls have none.
[[nodiscard]] std::optional<Op> op_of(std::string_view word);

/// Returns the word of a statement, or nullptr if the value is none of StmtOp.

/// True if a name can stand without quotes: [A-Za-z_] [A-Za-z0-9_.\[\]]*
[[nodiscard]] bool is_bare(std::string_view name);

struct ScopeVariable {
  std::string name;
  Type type = Type::Int;
  bool writable = true;
};
/// Self and Bind variables of the code of an atom type, a connector type or a priority.
struct CodeScope {
  std::vector<ScopeVariable> self;
  std::vector<ScopeVariable> bind;
  std::uint32_t draws = AtomType::kNoDraws;  // of self: the generator
};
/// Ids that are out of range contribute no variable: `validate` reports them apart.
[[nodiscard]] CodeScope scope_of(const AtomType& type);
[[nodiscard]] CodeScope scope_of(const System& system, const ConnectorType& type);
[[nodiscard]] CodeScope scope_of(const System& system, const Priority& priority);

}  // namespace bip::system::text
