// See bip2_names.hpp.
#include "compiler/migrate/bip2_names.hpp"

#include <algorithm>
#include <array>

namespace bip::migrate {
namespace {

// The reserved words of grammar/BipLexer.g4 that BIP1 has as names, sorted.
constexpr std::array<std::string_view, 19> kBip2Words = {
    "as",  "bool",     "const", "extern",   "fi",      "float",  "for",    "function", "if",  "int",
    "not", "operator", "or",    "property", "package", "refine", "string", "then",     "use",
};

bool is_word(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'; }

}  // namespace

Bip2Names::Bip2Names(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t begin = at;
    while (at < text.size() && is_word(text[at])) ++at;
    if (at > begin) taken_.emplace(text.substr(begin, at - begin));
    at += at == begin ? 1 : 0;
  }
}

std::string Bip2Names::name(std::string_view bip1) const {
  std::string made(bip1);
  if (std::find(kBip2Words.begin(), kBip2Words.end(), bip1) == kBip2Words.end()) return made;
  do made += '_';
  while (taken_.contains(made));
  return made;
}

std::string Bip2Names::path(const syntax::bip1::Path& path) const {
  std::string out;
  for (const syntax::Name& part : path) {
    if (!out.empty()) out += '.';
    out += name(part.text);
  }
  return out;
}

std::string Bip2Names::fresh(std::string wish) {
  std::string made = wish;
  for (int n = 2; !taken_.insert(made).second; ++n) made = wish + "_" + std::to_string(n);
  return made;
}

}  // namespace bip::migrate
