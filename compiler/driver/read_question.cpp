// See read_question.hpp.
#include "compiler/driver/read_question.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <utility>

namespace bip::driver {

std::optional<verify::Question> read_question(const char* command, const std::string& text,
                                              Result<verify::Question> read) {
  if (read) return std::move(*read);
  std::fputs(fmt::format("bipc {}: --property, {}\n  {}\n", command, read.error(), text).c_str(), stderr);
  return std::nullopt;
}

}  // namespace bip::driver
