// The pages of `bipc explain`, embedded at build time from compiler/diag/explain/*.md.
#pragma once
#include <span>
#include <string>
#include <string_view>

#include "compiler/diag/diagnostics.hpp"

namespace bip {

struct ExplainPage {
  std::string_view code;
  std::string_view text;  // markdown
};
/// All pages, by code. B and R and V codes.
[[nodiscard]] std::span<const ExplainPage> explain_pages();
/// The page of a code, or nullptr.
[[nodiscard]] const ExplainPage* find_page(std::string_view code);
/// A page for a terminal: fences become indented blocks, the heading a plain line.
[[nodiscard]] std::string render_page(const ExplainPage& page, Color color);

}  // namespace bip
