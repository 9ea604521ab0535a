// See small_instances.hpp.
#include "compiler/library/small_instances.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>

namespace bip::library {

namespace {

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }
bool is_word(char c) { return is_digit(c) || std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.'; }

}  // namespace

std::string scaled_root(const std::string& root, std::uint32_t size) {
  std::string result;
  const std::size_t open = root.find('(');
  bool is_in_string = false;
  for (std::size_t k = 0; k < root.size();) {
    if (root[k] == '"') is_in_string = !is_in_string;
    const bool begins_word = is_word(root[k]) && !is_in_string && k > open && open != std::string::npos;
    if (!begins_word) {
      result += root[k++];
      continue;
    }
    const std::size_t begin = k;
    while (k < root.size() && is_word(root[k])) ++k;
    const std::string word = root.substr(begin, k - begin);
    std::uint32_t value = 0;
    const bool is_int = std::all_of(word.begin(), word.end(), is_digit) &&
                        std::from_chars(word.data(), word.data() + word.size(), value).ec == std::errc();
    result += is_int && value > size ? std::to_string(size) : word;
  }
  return result;
}

std::optional<verify::SmallInstance> SmallInstanceCompiler::at(std::uint32_t size) {
  const std::string root = scaled_root(model_.options.root, size);
  if (model_.is_bsys() || root == model_.options.root) return std::nullopt;
  pipeline::CompileOptions options = model_.options;
  options.root = root;
  options.print_after = {};
  auto small = std::make_unique<pipeline::Compilation>(std::move(options));
  small->open_texts = model_.open_texts;
  if (!compile(*small, model_.path, pipeline::Stage::Image)) return std::nullopt;
  made_.push_back(std::move(small));
  return verify::SmallInstance{made_.back()->system.get(), &made_.back()->lowered->image};
}

}  // namespace bip::library
