// See property_text.hpp.
#include "compiler/verify/property/property_text.hpp"

#include <algorithm>

#include "compiler/system/index_expression.hpp"

namespace bip::verify {

void PropertyText::set_problem(const std::string& why) {
  if (problem_.empty()) problem_ = "column " + std::to_string(at_ + 1) + ": " + why;
}

void PropertyText::skip_blanks() {
  while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n')) ++at_;
}

bool PropertyText::take_sign(std::string_view sign) {
  skip_blanks();
  if (text_.compare(at_, sign.size(), sign) != 0) return false;
  at_ += sign.size();
  return true;
}

std::string PropertyText::parse_path() {
  skip_blanks();
  std::string path;
  while (at_ < text_.size() && begins_name(text_[at_])) {
    while (at_ < text_.size() && (begins_name(text_[at_]) || is_digit(text_[at_]))) path += text_[at_++];
    while (at_ < text_.size() && text_[at_] == '[') {
      std::size_t end = at_ + 1;
      while (end < text_.size() && is_digit(text_[end])) ++end;
      if (end > at_ + 1 && end < text_.size() && text_[end] == ']') {
        path.append(text_, at_, end + 1 - at_);
        at_ = end + 1;
      } else if (bound_.is_empty() || !take_index(path)) {
        return path;
      }
    }
    if (at_ + 1 >= text_.size() || text_[at_] != '.' || !begins_name(text_[at_ + 1])) break;
    path += text_[at_++];
  }
  return path;
}

std::optional<std::int64_t> PropertyText::evaluate(std::size_t& at) const {
  return system::evaluate_index(text_, at, [this](std::string_view name) { return bound_.value_of(name); });
}

bool PropertyText::take_index(std::string& path) {
  std::size_t at = at_ + 1;
  const std::optional<std::int64_t> index = evaluate(at);
  at = std::min(text_.find_first_not_of(" \t\n", at), text_.size());
  if (!index || at == text_.size() || text_[at] != ']') {
    set_problem("this index is no number: it may name variables that are bound around it");
    return false;
  }
  if (*index < 0) {
    set_problem("an index is at least 0, this is " + std::to_string(*index));
    return false;
  }
  path += '[' + std::to_string(*index) + ']';
  at_ = at + 1;
  return true;
}

bool PropertyText::is_at_number() const {
  const std::size_t digit = at_ < text_.size() && text_[at_] == '.' ? at_ + 1 : at_;
  return digit < text_.size() && is_digit(text_[digit]);
}

bool PropertyText::is_next(char c) {
  skip_blanks();
  return at_ < text_.size() && text_[at_] == c;
}

bool PropertyText::take_words(std::string_view words) {
  const std::size_t start = at_;
  for (std::size_t from = 0; from <= words.size();) {
    const std::size_t end = std::min(words.find(' ', from), words.size());
    if (parse_path() != words.substr(from, end - from) || is_next('@')) {
      at_ = start;
      return false;
    }
    from = end + 1;
  }
  return true;
}

std::string PropertyText::word_at(std::size_t start) const {
  return text_.substr(start, text_.find_first_of(" \t\n", start) - start);
}

}  // namespace bip::verify
