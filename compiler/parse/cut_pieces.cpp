// See cut_pieces.hpp. A declaration begins at a line `atom type`, `compound type`, `connector type` or `port type`, or
// at the annotations above it. Comments and strings are passed over. Files of the paper's notation are not cut.
#include "compiler/parse/cut_pieces.hpp"

#include <algorithm>
#include <functional>

#include "runtime/include/bip/assert.hpp"

namespace bip::parse {
namespace {

bool is_blank_sign(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// `atom type` and the others, as words of one line.
bool begins_type(std::string_view line) {
  for (const std::string_view word : {"atom", "compound", "connector", "port"}) {
    if (!line.starts_with(word)) continue;
    std::string_view rest = line.substr(word.size());
    const std::size_t blanks = std::min(rest.find_first_not_of(" \t"), rest.size());
    rest.remove_prefix(blanks);
    if (blanks == 0 || !rest.starts_with("type")) return false;
    return rest.size() > 4 && is_blank_sign(rest[4]);
  }
  return false;
}

class PieceSplitter {
 public:
  explicit PieceSplitter(std::string_view text) : text_(text) {}

  std::vector<std::uint32_t> run() {
    while (at_ < text_.size()) {
      begin_line();
      pass_line();
    }
    BIP_ASSERT(std::adjacent_find(cuts_.begin(), cuts_.end(), std::greater_equal<>()) == cuts_.end(),
               "{} cuts are not in order", cuts_.size());
    return std::move(cuts_);
  }

 private:
  void begin_line() {
    std::size_t first = at_;
    while (first < text_.size() && is_blank_sign(text_[first])) ++first;
    const std::string_view line = text_.substr(first, 64);
    if (begins_type(line)) {
      const std::size_t cut = marks_ == kNone ? at_ : marks_;
      if (cut > cuts_.back()) cuts_.push_back(static_cast<std::uint32_t>(cut));
      marks_ = kNone;
      parentheses_ = 0;
    } else if (line.starts_with('@') && parentheses_ == 0) {
      if (marks_ == kNone) marks_ = at_;
    } else if (!line.empty() && line.front() != '\n' && !line.starts_with("//") && !line.starts_with("/*") &&
               parentheses_ == 0) {
      marks_ = kNone;
    }
  }

  // To the begin of the next line that is not inside of a comment.
  void pass_line() {
    // Most lines hold neither, which the library's searches tell several bytes at a time.
    const std::size_t line_end = std::min(text_.find('\n', at_), text_.size());
    const std::string_view line = text_.substr(at_, line_end - at_);
    if (marks_ == kNone && line.find('"') == std::string_view::npos && line.find('/') == std::string_view::npos) {
      at_ = std::min(line_end + 1, text_.size());
      return;
    }
    while (at_ < text_.size()) {
      const char sign = text_[at_++];
      if (sign == '\n') return;
      if (sign == '"') {
        while (at_ < text_.size() && text_[at_] != '"' && text_[at_] != '\n')
          at_ += text_[at_] == '\\' && at_ + 1 < text_.size() && text_[at_ + 1] != '\n' ? 2 : 1;
        if (at_ < text_.size() && text_[at_] == '"') ++at_;
      } else if (sign == '/' && at_ < text_.size() && text_[at_] == '/') {
        at_ = std::min(text_.find('\n', at_), text_.size());
      } else if (sign == '/' && at_ < text_.size() && text_[at_] == '*') {
        const std::size_t end = text_.find("*/", at_ + 1);
        at_ = end == std::string_view::npos ? text_.size() : end + 2;
      } else if (marks_ != kNone) {
        // An annotation may go over several lines.
        parentheses_ += (sign == '(' ? 1 : 0) - (sign == ')' ? 1 : 0);
      }
    }
  }

  static constexpr std::size_t kNone = std::string_view::npos;

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t marks_ = kNone;  // where the annotations above this line begin
  int parentheses_ = 0;        // that are open in them
  std::vector<std::uint32_t> cuts_{0};
};

}  // namespace

std::vector<std::uint32_t> cut_pieces(std::string_view text) { return PieceSplitter(text).run(); }

}  // namespace bip::parse
