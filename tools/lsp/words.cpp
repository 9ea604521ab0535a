// See words.hpp.
#include "tools/lsp/words.hpp"

#include <algorithm>
#include <cctype>

namespace bip::lsp {
namespace {

constexpr std::string_view kKeywords[] = {
    "and",      "as",        "at",        "atom",     "behavior", "behaviour", "bool",      "clock", "component",
    "compound", "connector", "const",     "contains", "data",     "define",    "delayable", "do",    "double",
    "down",     "eager",     "else",      "end",      "error",    "export",    "extern",    "false", "fi",
    "final",    "float",     "for",       "from",     "function", "if",        "ignore",    "in",    "initial",
    "int",      "internal",  "invariant", "lazy",     "not",      "on",        "operator",  "or",    "package",
    "place",    "port",      "priority",  "provided", "refine",   "remember",  "resume",    "state", "string",
    "then",     "to",        "true",      "type",     "unit",     "up",        "use"};
static_assert(std::ranges::is_sorted(kKeywords));

}  // namespace

bool is_name_character(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

bool is_keyword(std::string_view word) { return std::ranges::binary_search(kKeywords, word); }

bool is_plain_name(std::string_view name) {
  return !name.empty() && std::isdigit(static_cast<unsigned char>(name.front())) == 0 &&
         std::ranges::all_of(name, is_name_character) && !is_keyword(name);
}

Words cut_into_words(std::string_view text) {
  Words words;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::string_view rest = text.substr(at);
    const bool is_line = rest.starts_with("//");
    if (is_line || rest.starts_with("/*")) {
      const std::size_t end = is_line ? rest.find('\n') : rest.find("*/", 2);
      words.inside_comment = end == std::string_view::npos;
      if (words.inside_comment) return words;
      at += end + (is_line ? 1 : 2);
    } else if (rest.front() == '"') {
      std::size_t end = 1;
      while (end < rest.size() && rest[end] != '"' && rest[end] != '\n') end += rest[end] == '\\' ? 2u : 1u;
      words.inside_string = end >= rest.size();
      if (words.inside_string) return words;
      words.list.push_back({rest.substr(0, end + 1), static_cast<std::uint32_t>(at)});
      at += end + 1;
    } else if (is_name_character(rest.front())) {
      const auto end = static_cast<std::size_t>(std::ranges::find_if_not(rest, is_name_character) - rest.begin());
      words.list.push_back({rest.substr(0, end), static_cast<std::uint32_t>(at)});
      at += end;
    } else {
      if (std::isspace(static_cast<unsigned char>(rest.front())) == 0)
        words.list.push_back({rest.substr(0, 1), static_cast<std::uint32_t>(at)});
      ++at;
    }
  }
  return words;
}

}  // namespace bip::lsp
