// Decodes escapes of string literals. \uXXXX becomes UTF-8 (a surrogate is not a character, hence a bad escape); \ooo
// is one byte.
#include "compiler/parse/unescape.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::parse {
namespace {

int digit(char c, int base) {
  int value = -1;
  if (c >= '0' && c <= '9') value = c - '0';
  if (c >= 'a' && c <= 'f') value = c - 'a' + 10;
  if (c >= 'A' && c <= 'F') value = c - 'A' + 10;
  return value < base ? value : -1;
}

void append_utf8(std::uint32_t code, std::string& out) {
  BIP_ASSERT(code < 0x10000 && (code < 0xD800 || code > 0xDFFF), "{} is no character of three bytes", code);
  const auto byte = [&](std::uint32_t b) { out += static_cast<char>(static_cast<unsigned char>(b)); };
  if (code < 0x80) return byte(code);
  if (code < 0x800) {
    byte(0xC0u | (code >> 6u));
    return byte(0x80u | (code & 0x3Fu));
  }
  byte(0xE0u | (code >> 12u));
  byte(0x80u | ((code >> 6u) & 0x3Fu));
  byte(0x80u | (code & 0x3Fu));
}

/// Reads digits of `base` from `at`, at most `most`; returns how many.
std::size_t read_digits(std::string_view body, std::size_t at, std::size_t most, int base, std::uint32_t& value) {
  std::size_t n = 0;
  BIP_ASSERT(most <= 8 && at <= body.size(), "{} digits at {} of {} bytes", most, at, body.size());
  value = 0;
  while (n < most && at + n < body.size() && digit(body[at + n], base) >= 0) {
    value = value * static_cast<std::uint32_t>(base) + static_cast<std::uint32_t>(digit(body[at + n], base));
    ++n;
  }
  return n;
}

}  // namespace

std::string_view string_body(std::string_view literal) {
  constexpr std::string_view kOpen = "\xE2\x80\x9C";
  constexpr std::string_view kClose = "\xE2\x80\x9D";
  if (literal.substr(0, 3) == kOpen) {
    literal.remove_prefix(3);
    if (literal.size() >= 3 && literal.substr(literal.size() - 3) == kClose) literal.remove_suffix(3);
    return literal;
  }
  BIP_ASSERT(literal.starts_with('"'), "a string of {} bytes without its quote", literal.size());
  literal.remove_prefix(1);
  // A quote that an odd number of backslashes precedes belongs to the string.
  if (!literal.empty() && literal.back() == '"') {
    std::size_t slashes = 0;
    while (slashes + 1 < literal.size() && literal[literal.size() - 2 - slashes] == '\\') ++slashes;
    if (slashes % 2 == 0) literal.remove_suffix(1);
  }
  return literal;
}

std::vector<BadEscape> unescape(std::string_view body, std::string& out) {
  std::vector<BadEscape> bad;
  for (std::size_t i = 0; i < body.size(); ++i) {
    if (body[i] != '\\' || i + 1 >= body.size()) {
      out += body[i];
      continue;
    }
    const char c = body[i + 1];
    constexpr std::string_view kLetters = "btnfr\"'\\";
    constexpr std::string_view kMeanings = "\b\t\n\f\r\"'\\";
    std::uint32_t code = 0;
    if (const std::size_t k = kLetters.find(c); k != std::string_view::npos) {
      out += kMeanings[k];
      i += 1;
    } else if (c == 'u' && read_digits(body, i + 2, 4, 16, code) == 4 && (code < 0xD800 || code > 0xDFFF)) {
      append_utf8(code, out);
      i += 5;
    } else if (const std::size_t n = read_digits(body, i + 1, c <= '3' ? 3 : 2, 8, code); n > 0) {
      out += static_cast<char>(static_cast<unsigned char>(code));
      i += n;
    } else {
      bad.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(i + 2)});
      out += body[i];
    }
  }
  return bad;
}

}  // namespace bip::parse
