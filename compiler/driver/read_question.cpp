// See read_question.hpp.
#include "compiler/driver/read_question.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <utility>

namespace bip::driver {

std::optional<verify::Question> read_question(const char* command, const std::string& text, const System& system) {
  verify::Question question;
  if (text.empty() || text == "deadlock") return question;
  if (text == "errors") {
    question.what = verify::QuestionKind::NoErrors;
    return question;
  }
  Result<verify::Property> property = verify::parse_property(text, system);
  if (!property) {
    std::fputs(fmt::format("bipc {}: --property, {}\n  {}\n", command, property.error(), text).c_str(), stderr);
    return std::nullopt;
  }
  question.what = verify::QuestionKind::State;
  question.property = std::move(*property);
  return question;
}

}  // namespace bip::driver
