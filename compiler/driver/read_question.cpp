// See read_question.hpp.
#include "compiler/driver/read_question.hpp"

#include <fmt/format.h>

#include <utility>

#include "compiler/driver/report.hpp"
#include "compiler/library/suggest_property.hpp"

namespace bip::driver {

std::optional<verify::Question> read_question(const std::string& text, Result<verify::Question> read,
                                              const System& system) {
  if (read) return std::move(*read);
  usage_error(fmt::format("--property, {}\n  {}", read.error(), text));
  if (const std::optional<library::PropertySuggestion> meant = library::suggest_property(text, system)) {
    if (!meant->note.empty()) print_error_words("  = note: " + meant->note);
    if (!meant->property.empty()) print_error_words("  = help: --property '" + meant->property + "'");
  }
  return std::nullopt;
}

}  // namespace bip::driver
