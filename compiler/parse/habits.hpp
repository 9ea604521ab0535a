// What people write by habit of another language (C, Python, UPPAAL, Lingua Franca), and how BIP says it.
//
// A flat table of patterns around the word at which the parser stopped. The first row that fits gives a note and, for
// most rows, an edit. Precision only: a row that fits wrongly adds a wrong hint to an error that is reported anyway.
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "antlr4-runtime.h"

namespace bip::parse {

struct Habit {
  std::string_view note;  // why this is not BIP
  bool has_edit = false;
  std::size_t begin = 0, end = 0;  // the bytes that `with` replaces
  std::string with;
};

/// The habit that explains why the parser stopped at `found` inside `context`, if one is known.
[[nodiscard]] std::optional<Habit> find_habit(antlr4::TokenStream& tokens, const antlr4::RuleContext* context,
                                              const antlr4::Token& found, std::string_view text);

}  // namespace bip::parse
