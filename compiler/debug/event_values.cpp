// See event_values.hpp.
#include "compiler/debug/event_values.hpp"

#include <algorithm>
#include <charconv>
#include <string>

namespace bip::debug {

std::vector<EventValue> event_values(std::string_view words) {
  std::vector<EventValue> values;
  for (std::size_t at = 0; (at = words.find_first_not_of(" \t", at)) != std::string_view::npos;) {
    const std::size_t end = std::min(words.find_first_of(" \t", at), words.size());
    const std::string word(words.substr(at, end - at));
    at = end;
    std::int32_t whole = 0;
    double real = 0;
    const char* const last = word.data() + word.size();
    if (word == "true" || word == "false") values.emplace_back(word == "true");
    else if (const auto read = std::from_chars(word.data(), last, whole); read.ec == std::errc() && read.ptr == last)
      values.emplace_back(whole);
    else if (const auto as_real = std::from_chars(word.data(), last, real);
             as_real.ec == std::errc() && as_real.ptr == last)
      values.emplace_back(real);
    else
      values.emplace_back(
          word.size() >= 2 && word.front() == '"' && word.back() == '"' ? word.substr(1, word.size() - 2) : word);
  }
  return values;
}

}  // namespace bip::debug
