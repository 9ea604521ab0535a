// Prints code as BIP text in one line: guards, actions and transfers for pictures and JSON.
//
// Names come from the owner of the code. Code that the compiler adds is not printed: conversions to float, and the
// hidden variables of time, whose stores are printed as assignments to the clock. Requires code that `validate`
// accepts; recursion follows its nesting, which is limited there. Linear in the output.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "compiler/system/system_ids.hpp"

namespace bip::graph {

/// What a piece of code calls its variables. A store to a variable without a name is not shown.
struct CodeNames {
  std::vector<std::string> self{}, bind{};
};
[[nodiscard]] CodeNames names_of(const AtomType& type);
[[nodiscard]] CodeNames names_of(const System& system, const ConnectorType& type);
[[nodiscard]] CodeNames names_of(const System& system, const Priority& priority);

/// Returns the code in one line; "" for no expression and no statement.
[[nodiscard]] std::string text_of(const CodeTable& code, ExprId expr, const CodeNames& names);
[[nodiscard]] std::string text_of(const CodeTable& code, StmtId first, const CodeNames& names);
[[nodiscard]] std::string text_of(const CodeTable& code, const Value& value);
/// Returns a condition on data and on clocks: "n < 3 && x >= 5". Limits are in the clock's unit. Empty if it always
/// holds.
[[nodiscard]] std::string condition_of(const CodeTable& code, const AtomType& type, ExprId guard,
                                       const TimeGuard& when);
/// Returns "[text]", or nothing of no text.
[[nodiscard]] std::string in_brackets(const std::string& text);
/// Returns "resume [condition]", empty if there is none.
[[nodiscard]] std::string resume_text(const CodeTable& code, const AtomType& type, const Resume& resume);
/// What stands above an automaton.
struct AtomTypeHeading {
  std::string name;                // with its parameters
  std::vector<std::string> lines;  // data, clocks (these two may be empty), then what restricts the transitions
};
[[nodiscard]] AtomTypeHeading heading_of(const CodeTable& code, const AtomType& type);
/// Returns the `define` tree over the names of the parameters: "a' (b c)".
[[nodiscard]] std::string define_of(const ConnectorType& type);
/// Joins the names of the rows: "a, b".
[[nodiscard]] std::string list_of(const std::vector<std::uint32_t>& rows, const std::vector<std::string>& names,
                                  std::string_view between = ", ");

}  // namespace bip::graph
