// Descriptions for messages: of a token, of a set of expected tokens, of the construct that was being parsed.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "antlr4-runtime.h"

namespace bip::parse {

/// "`from`", "a name", "end of file".
[[nodiscard]] std::string describe_token_type(std::size_t type);

/// The spelling of a keyword or sign, empty for names, literals and tokens without one spelling.
[[nodiscard]] std::string_view spelling(std::size_t type);

/// At most five alternatives, the likeliest first: "`from`, `to` or `do`"; groups such as "an expression" stand for
/// many.
[[nodiscard]] std::string describe_expected(const antlr4::misc::IntervalSet& expected);

/// Spellings of the words in the set, to compare with a misspelled name.
[[nodiscard]] std::vector<std::string> words_of(const antlr4::misc::IntervalSet& expected);

/// "in a transition of atom type `Node`", empty at the top of a file.
[[nodiscard]] std::string describe_place(const antlr4::RuleContext* context, std::string_view text);

/// The innermost declaration that ends with `end`: "atom type `Node`"; `opener` is its first token. Empty if none.
struct Owner {
  std::string phrase;
  const antlr4::Token* opener = nullptr;
};
/// The declaration below `context` whose `end` is `last`; empty if none.
[[nodiscard]] Owner find_closed_by(const antlr4::RuleContext* context, const antlr4::Token* last,
                                   std::string_view text);
[[nodiscard]] Owner find_owner(const antlr4::RuleContext* context, std::string_view text);

}  // namespace bip::parse
