// See quantifier.hpp.
#include "compiler/verify/property/quantifier.hpp"

#include "compiler/base/ascii.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

std::size_t end_of_body(std::string_view text, std::size_t begin, Reach reach) {
  BIP_ASSERT(begin <= text.size(), "a text of {} bytes from {} on", text.size(), begin);
  const auto is_of_name = [&](std::size_t at) { return is_letter(text[at]) || is_digit(text[at]) || text[at] == '_'; };
  int open = 0;
  bool is_in_string = false;
  for (std::size_t at = begin; at < text.size(); ++at) {
    if (text[at] == '"') is_in_string = !is_in_string;
    if (is_in_string) continue;
    if (text[at] == '(') ++open;
    if (text[at] == ')' && --open < 0) return at;
    if (reach == Reach::Formula || open > 0 || !is_of_name(at) || (at > begin && is_of_name(at - 1))) continue;
    std::size_t end = at;
    while (end < text.size() && is_of_name(end)) ++end;
    for (const std::string_view connective : {"leads", "implies", "until", "unless", "since"}) {
      if (text.substr(at, end - at) == connective) return at;
    }
  }
  return text.size();
}

}  // namespace bip::verify
