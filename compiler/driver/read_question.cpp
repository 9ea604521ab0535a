// See read_question.hpp.
#include "compiler/driver/read_question.hpp"

#include <fmt/format.h>

#include <utility>

#include "compiler/driver/report.hpp"
#include "compiler/library/suggest_property.hpp"

namespace bip::driver {

namespace {

void print_suggestion(const std::optional<library::PropertySuggestion>& meant, const char* option) {
  if (!meant) return;
  if (!meant->note.empty()) print_error_words("  = note: " + meant->note);
  if (!meant->property.empty()) print_error_words(fmt::format("  = help: {} '{}'", option, meant->property));
}

}  // namespace

std::optional<verify::Question> read_question(const std::string& text, Result<verify::Question> read,
                                              const System& system) {
  if (read) return std::move(*read);
  usage_error(fmt::format("--property, {}\n  {}", read.error(), text));
  print_suggestion(library::suggest_property(text, system), "--property");
  return std::nullopt;
}

std::optional<verify::Fairness> read_fairness(const std::string& text, const System& system) {
  Result<verify::Fairness> read = verify::read_fairness(text, system);
  if (read) return std::move(*read);
  usage_error(fmt::format("--fair, {}\n  {}", read.error(), text));
  print_suggestion(library::suggest_fairness(text, system), "--fair");
  return std::nullopt;
}

}  // namespace bip::driver
