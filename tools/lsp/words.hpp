// The words of the language for completion, and a scanner that splits text into words without comments and strings.
//
// The scanner is not a lexer: it never fails, so it works on incomplete text.
#pragma once
#include <cstdint>
#include <string_view>
#include <vector>

namespace bip::lsp {

struct Word {
  std::string_view text;  // a name, a number, or one sign
  std::uint32_t begin = 0;
};

/// Words of `text`, in order. `inside` says whether its end is in a comment or a string.
struct Words {
  std::vector<Word> list;
  bool inside_comment = false;
  bool inside_string = false;
};
[[nodiscard]] Words cut_into_words(std::string_view text);

[[nodiscard]] bool is_name_character(char c);
[[nodiscard]] bool is_keyword(std::string_view word);
/// A name that may be given to anything: no word of the language, contextual ones included.
[[nodiscard]] bool is_plain_name(std::string_view name);

}  // namespace bip::lsp
