// See ffi_cache.hpp. An entry: a line with the hash, the library.
#include "compiler/pipeline/ffi_cache.hpp"

namespace bip::pipeline {

std::vector<std::string> prerequisites(std::string_view rule) {
  std::vector<std::string> found;
  std::string word;
  const auto end_word = [&] {
    if (!word.empty() && word.back() != ':') found.push_back(word);
    word.clear();
  };
  for (std::size_t k = 0; k < rule.size(); ++k) {
    const char c = rule[k], next = k + 1 < rule.size() ? rule[k + 1] : '\n';
    const bool is_escape = (c == '\\' && (next == ' ' || next == '#' || next == '\\')) || (c == '$' && next == '$');
    if (is_escape) word += rule[++k];
    else if (c == '\\' && next == '\n') ++k, end_word();
    else if (c == ' ' || c == '\n' || c == '\t') end_word();
    else word += c;
  }
  end_word();
  return found;
}

std::string pack_library(std::string_view hash, std::string_view library) {
  return std::string(hash) + '\n' + std::string(library);
}

std::optional<std::string_view> unpack_library(std::string_view hash, std::string_view entry) {
  if (hash.empty() || !entry.starts_with(hash)) return std::nullopt;
  entry.remove_prefix(hash.size());
  if (!entry.starts_with('\n')) return std::nullopt;
  return entry.substr(1);
}

}  // namespace bip::pipeline
