// See expand_property.hpp. One pass over the text; what it does not know it copies.
#include "compiler/system/expand_property.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "compiler/base/ascii.hpp"
#include "compiler/system/index_expression.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::system {

namespace {

bool begins_name(char c) { return is_letter(c) || c == '_'; }

class PropertyExpander {
 public:
  PropertyExpander(std::string_view text, const std::string& scope,
                   const std::map<std::string, Value, std::less<>>& constants, const std::vector<std::string>& strings)
      : text_(text), scope_(scope), constants_(constants), strings_(strings) {}

  Result<ExpandedProperty> run() {
    while (at_ < text_.size() && problem_.empty()) expand_token();
    if (!problem_.empty()) return Failure{problem_};
    while (!out_.text.empty() && out_.text.back() == ' ') {
      out_.text.pop_back();
      out_.source.pop_back();
    }
    out_.source.push_back(static_cast<std::uint32_t>(std::min(text_.find_last_not_of(" \t\r\n") + 1, text_.size())));
    BIP_ASSERT(out_.source.size() == out_.text.size() + 1, "{} places of {} bytes", out_.source.size(),
               out_.text.size());
    return std::move(out_);
  }

 private:
  void put(std::string_view what, std::size_t from) {
    out_.text.append(what);
    out_.source.insert(out_.source.end(), what.size(), static_cast<std::uint32_t>(from));
  }
  void copy_until(std::size_t end) {
    for (; at_ < end; ++at_) put(text_.substr(at_, 1), at_);
  }
  [[nodiscard]] char peek(std::size_t at) const { return at < text_.size() ? text_[at] : '\0'; }
  [[nodiscard]] static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

  void expand_token() {
    const char c = text_[at_];
    const std::string_view two = text_.substr(at_, 2);
    if (is_blank(c)) {
      put_blank();
      ++at_;
    } else if (two == "//" || two == "/*") {
      put_blank();
      const std::size_t end = text_.find(two == "//" ? "\n" : "*/", at_ + 2);
      at_ = end == std::string_view::npos ? text_.size() : end + (two == "//" ? 1 : 2);
    } else if (c == '"') {
      const std::size_t end = text_.find('"', at_ + 1);
      copy_until(end == std::string_view::npos ? text_.size() : end + 1);
      last_word_ = {};
    } else if (is_digit(c)) {
      std::size_t end = at_;
      // `0..n` is no number.
      while (end < text_.size() && text_.substr(end, 2) != ".." &&
             (is_digit(text_[end]) || begins_name(text_[end]) || text_[end] == '.'))
        ++end;
      copy_until(end);
      is_unit_ = last_word_ == "within";
      last_word_ = {};
    } else if (begins_name(c)) {
      expand_name();
    } else {
      if (c == '(') ++parentheses_;
      if (c == ')') close_parenthesis();
      is_place_ = c == '@';
      is_fair_ = c == ':' && has_under_ && (last_word_ == "weak" || last_word_ == "strong");
      is_unit_ = false;
      last_word_ = {};
      copy_until(at_ + 1);
    }
  }
  void put_blank() {
    if (!out_.text.empty() && out_.text.back() != ' ') put(" ", at_);
  }
  [[nodiscard]] std::string_view word_at(std::size_t at) const {
    std::size_t end = at;
    while (end < text_.size() && (begins_name(text_[end]) || is_digit(text_[end]))) ++end;
    return text_.substr(at, end - at);
  }

  void expand_name() {
    const std::string_view word = word_at(at_);
    if (is_place_) {
      is_place_ = false;
      return copy_until(at_ + word.size());
    }
    if (std::exchange(is_unit_, false)) return copy_until(at_ + word.size());
    std::size_t behind = at_ + word.size();
    const bool is_path = peek(behind) == '[' || (peek(behind) == '.' && begins_name(peek(behind + 1)));
    while (is_blank(peek(behind))) ++behind;
    const bool is_component = peek(behind) == '@';
    const bool is_offer = last_word_ == "can" || last_word_ == "happens";
    const bool is_fair = std::exchange(is_fair_, false) && word != "atoms";
    const bool is_array = last_word_ == "in" && !is_bound(word) && !constants_.contains(word);
    if (!is_path && word_at(behind) == "in") bound_.push_back({word, parentheses_});
    is_unit_ = last_word_ == "within";
    last_word_ = word;
    has_under_ = has_under_ || (word == "under" && !is_path && !is_component && !is_offer && !is_fair);
    if (is_path || is_component || is_offer || is_array || is_fair) return expand_path(word);
    if (is_bound(word)) return copy_until(at_ + word.size());
    if (const auto constant = constants_.find(word); constant != constants_.end()) {
      put(value_text(constant->second), at_);
      at_ += word.size();
      return;
    }
    copy_until(at_ + word.size());
  }
  void expand_path(std::string_view word) {
    if (word != "ROOT") put(scope_, at_);
    for (;;) {
      copy_until(at_ + word_at(at_).size());
      while (peek(at_) == '[' && problem_.empty()) expand_index();
      if (peek(at_) != '.' || !begins_name(peek(at_ + 1)) || !problem_.empty()) return;
      copy_until(at_ + 1);
    }
  }
  void expand_index() {
    const std::size_t open = at_++;
    // Each position, of which fairness speaks.
    if (has_under_ && text_.substr(open, 3) == "[*]") return copy_each(open);
    if (has_bound_name(open)) {
      // What else it names has a value now.
      put("[", open);
      while (at_ < text_.size() && text_[at_] != ']' && problem_.empty()) expand_token();
      if (at_ < text_.size()) copy_until(at_ + 1);
      last_word_ = {};
      return;
    }
    const std::optional<std::int64_t> index =
        evaluate_index(text_, at_, [this](std::string_view word) -> std::optional<std::int64_t> {
          const auto constant = constants_.find(word);
          if (constant == constants_.end() || constant->second.type != Type::Int) return std::nullopt;
          return constant->second.int_value;
        });
    skip_blanks();
    if (!index || peek(at_) != ']') {
      const std::size_t close = std::min(text_.find(']', open), text_.size() - 1);
      problem_ = fmt::format("the index `{}` is no number: it may name parameters and variables of loops",
                             text_.substr(open, close - open + 1));
    } else if (*index < 0) {
      problem_ = fmt::format("an index is at least 0, this is {}", *index);
    } else {
      put(fmt::format("[{}]", *index), open);
      ++at_;
    }
  }

  void copy_each(std::size_t open) {
    put("[*]", open);
    at_ = open + 3;
  }

  void skip_blanks() {
    while (is_blank(peek(at_))) ++at_;
  }

  // ---- variables of quantifiers: `forall i in phil: …` binds `i` up to the end of the parentheses around it
  [[nodiscard]] bool is_bound(std::string_view word) const {
    return std::any_of(bound_.begin(), bound_.end(), [&](const BoundName& bound) { return bound.name == word; });
  }
  // Does a bound variable stand in the index that opens here?
  [[nodiscard]] bool has_bound_name(std::size_t open) const {
    for (std::size_t at = open + 1; at < text_.size() && text_[at] != ']';) {
      const std::string_view word = begins_name(text_[at]) ? word_at(at) : std::string_view();
      if (is_bound(word)) return true;
      at += std::max<std::size_t>(word.size(), 1);
    }
    return false;
  }
  void close_parenthesis() {
    --parentheses_;
    std::erase_if(bound_, [this](const BoundName& bound) { return bound.parentheses > parentheses_; });
  }

  [[nodiscard]] std::string value_text(const Value& value) const {
    if (value.type == Type::Bool) return value.int_value != 0 ? "true" : "false";
    if (value.type == Type::String) return '"' + strings_[static_cast<std::size_t>(value.int_value)] + '"';
    std::string digits =
        value.type == Type::Float ? fmt::format("{}", value.float_value) : fmt::format("{}", value.int_value);
    // A whole number stays a `float`.
    if (value.type == Type::Float && digits.find_first_of(".en") == std::string::npos) digits += ".0";
    return digits.front() == '-' ? "(" + digits + ")" : digits;
  }

  std::string_view text_;
  const std::string& scope_;
  const std::map<std::string, Value, std::less<>>& constants_;
  const std::vector<std::string>& strings_;
  struct BoundName {
    std::string_view name;
    int parentheses = 0;  // that are open around it
  };
  std::vector<BoundName> bound_;
  int parentheses_ = 0;
  ExpandedProperty out_;
  std::string problem_;
  std::string_view last_word_;  // of the tokens before this one, if it is a name
  bool is_place_ = false;       // behind `@`
  bool has_under_ = false;      // fairness follows
  bool is_fair_ = false;        // behind the `:` of `weak:` or `strong:`
  bool is_unit_ = false;        // behind the number of `within 50 ms`: no name of a parameter
  std::size_t at_ = 0;
};

}  // namespace

Result<ExpandedProperty> expand_property(std::string_view text, const std::string& scope,
                                         const std::map<std::string, Value, std::less<>>& constants,
                                         const std::vector<std::string>& strings) {
  return PropertyExpander(text, scope, constants, strings).run();
}

}  // namespace bip::system
