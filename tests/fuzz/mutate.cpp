// The edits. Half of them are of single bytes; the others keep words whole, so that they reach behind the parser.
#include "tests/fuzz/mutate.hpp"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <utility>

namespace bip::fuzz {
namespace {

constexpr const char* kWords[] = {"end",        "'",
                                  "[*]",        "0..",
                                  "index",      "export",
                                  "port",       "package",
                                  "(",          ")",
                                  "{",          "}",
                                  "[",          "]",
                                  "*",          ".",
                                  ",",          ":",
                                  "<",          "=",
                                  "-1",         "99999999999",
                                  "2147483647", "1.5e308",
                                  "\"",         "\\u00e9",
                                  "/*",         "//",
                                  "@",          "if",
                                  "fi",         "then",
                                  "else",       "for",
                                  "in",         "define",
                                  "provided",   "\xE2\x80\x99",
                                  "\xC3",       "_",
                                  "true",       "data",
                                  "const",      "extern",
                                  "priority",   "on",
                                  "from",       "to",
                                  "do",         "up",
                                  "down",       "PARAMS-NOT-SET",
                                  "behavior",   "state",
                                  "not",        "resume",
                                  "clock",      "at",
                                  "invariant"};

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

// The word at or after a place: begin and length.
std::pair<std::size_t, std::size_t> word_at(const std::string& text, std::size_t at) {
  while (at > 0 && is_word(text[at - 1])) --at;
  while (at < text.size() && !is_word(text[at])) ++at;
  std::size_t end = at;
  while (end < text.size() && is_word(text[end])) ++end;
  return {at, end - at};
}

std::pair<std::size_t, std::size_t> line_at(const std::string& text, std::size_t at) {
  const std::size_t before = at == 0 ? std::string::npos : text.rfind('\n', at - 1);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  const std::size_t end = text.find('\n', at);
  return {begin, (end == std::string::npos ? text.size() : end + 1) - begin};
}

void edit(std::string& text, const std::string& other, Random& random) {
  if (text.empty() || other.empty()) return;
  const std::size_t at = random.below(text.size());
  const std::size_t there = random.below(other.size());
  switch (random.below(12)) {
    case 0: text[at] = static_cast<char>(random.below(256)); return;
    case 1: text[at] = static_cast<char>(32 + random.below(95)); return;
    case 2: text[at] = static_cast<char>(text[at] ^ (1 << random.below(8))); return;
    case 3: text.erase(at, 1); return;
    case 4: text.insert(at, 1, static_cast<char>(32 + random.below(95))); return;
    case 5: text.erase(at, 1 + random.below(std::min<std::size_t>(text.size() - at, 40))); return;
    case 6: text.insert(at, kWords[random.below(std::size(kWords))]); return;
    case 7: {
      const auto [begin, length] = word_at(text, at);
      text.replace(begin, length, kWords[random.below(std::size(kWords))]);
      return;
    }
    case 8:
    case 9: {
      const auto [begin, length] = word_at(text, at);
      const auto [from, size] = word_at(other, there);
      text.replace(begin, length, other.substr(from, size));
      return;
    }
    case 10: {
      const auto [from, size] = line_at(other, there);
      text.insert(line_at(text, at).first, other.substr(from, size));
      return;
    }
    default: {
      const auto [begin, length] = line_at(text, at);
      text.erase(begin, length);
    }
  }
}

}  // namespace

std::uint64_t Random::next() {
  std::uint64_t z = state_ += 0x9E3779B97F4A7C15u;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

std::string mutated(const std::vector<std::string>& sources, Random& random) {
  std::string text = sources[random.below(sources.size())];
  const std::size_t most = text.size() + text.size() / 3 + 100;
  // Half of the time a single edit: more of them are accepted, and what comes after the check is tried too.
  for (std::size_t edits = random.below(2) == 0 ? 1 : 2 + random.below(7); edits > 0 && text.size() < most; --edits) {
    edit(text, random.below(2) == 0 ? text : sources[random.below(sources.size())], random);
  }
  if (text.size() > most) text.resize(most);
  return text;
}

}  // namespace bip::fuzz
