// See ffi_cache.hpp. An entry: a line "HASH PATH" per file, an empty line, the library.
#include "compiler/pipeline/ffi_cache.hpp"

#include <algorithm>

#include "compiler/base/content_hash.hpp"
#include "compiler/base/read_file.hpp"

namespace bip::pipeline {

namespace {

constexpr std::size_t kDigits = 64;

std::optional<std::string> hash_of_file(const std::string& path) {
  const std::optional<std::string> bytes = read_file(path);
  return bytes ? std::optional(blake2b(*bytes)) : std::nullopt;
}

}  // namespace

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

std::optional<std::string> pack_library(std::vector<std::string> files, std::string_view library) {
  std::sort(files.begin(), files.end());
  files.erase(std::unique(files.begin(), files.end()), files.end());
  std::string entry;
  for (const std::string& file : files) {
    const std::optional<std::string> hash = hash_of_file(file);
    if (!hash || file.find('\n') != std::string::npos) return std::nullopt;
    entry += *hash + ' ' + file + '\n';
  }
  return entry + '\n' + std::string(library);
}

std::optional<std::string_view> unpack_library(std::string_view entry) {
  for (std::size_t at = 0; at < entry.size();) {
    const std::size_t end = entry.find('\n', at);
    if (end == at) return entry.substr(end + 1);
    if (end == std::string_view::npos || end - at < kDigits + 2) return std::nullopt;
    const std::string path(entry.substr(at + kDigits + 1, end - at - kDigits - 1));
    if (hash_of_file(path) != std::string(entry.substr(at, kDigits))) return std::nullopt;
    at = end + 1;
  }
  return std::nullopt;
}

}  // namespace bip::pipeline
