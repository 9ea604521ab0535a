// Reads no more of a file than comments and its first two words.
#include "compiler/parse/head_of_bip1.hpp"

#include <cstdint>
#include <string_view>

namespace bip::parse {

SourceRange head_of_bip1(const SourceMap& sources, FileId file) {
  const std::string_view text = sources.text(file);
  constexpr std::string_view kBlanks = " \t\r\n", kWord = "model";
  std::size_t at = 0;
  for (;;) {
    at = text.find_first_not_of(kBlanks, at);
    if (at == std::string_view::npos) return {};
    const bool is_line = text.substr(at).starts_with("//");
    if (!is_line && !text.substr(at).starts_with("/*")) break;
    at = is_line ? text.find('\n', at) : text.find("*/", at + 2);
    if (at == std::string_view::npos) return {};
    if (!is_line) at += 2;
  }
  if (!text.substr(at).starts_with(kWord)) return {};
  const std::size_t end = at + kWord.size();
  const std::size_t name = text.find_first_not_of(" \t", end);
  if (name == std::string_view::npos || name == end) return {};
  const char first = text[name];
  if (!(first == '_' || (first >= 'a' && first <= 'z') || (first >= 'A' && first <= 'Z'))) return {};
  return {file, static_cast<std::uint32_t>(at), static_cast<std::uint32_t>(end)};
}

}  // namespace bip::parse
