// The lines of the printer: indentation, comments, blank lines. Of consecutive blank lines of the source one is kept,
// none at the beginning or end of a block. Linear in the text.
#include "compiler/syntax/print.hpp"

#include <algorithm>

#include "compiler/syntax/printer.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::syntax {

std::string print(const Syntax& syntax, const SourceMap& sources) { return SyntaxPrinter(syntax, sources).run(); }

std::string SyntaxPrinter::run() {
  if (syntax_.package != nullptr) package(*syntax_.package);
  lead_in(static_cast<std::uint32_t>(source_.size()), static_cast<std::uint32_t>(source_.size()));
  BIP_ASSERT(indent_ == 0 && next_comment_ == syntax_.comments.size(), "{} of {} comments were printed", next_comment_,
             syntax_.comments.size());
  return std::move(out_);
}

void SyntaxPrinter::print_in_order(std::vector<Piece>& pieces) {
  std::stable_sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) { return a.begin < b.begin; });
  for (const Piece& piece : pieces) piece.print();
}

void SyntaxPrinter::begin_line() {
  BIP_ASSERT(out_.empty() || out_.back() == '\n', "a line begins within another, after {} bytes", out_.size());
  line_start_ = out_.size();
  out_.append(static_cast<std::size_t>(indent_) * 2, ' ');
  first_in_block_ = false;
}

bool SyntaxPrinter::has_comment_before(std::uint32_t offset) const {
  return next_comment_ < syntax_.comments.size() && syntax_.comments[next_comment_].range.begin < offset;
}

void SyntaxPrinter::blank_line_if_source_has_one(std::uint32_t begin) {
  if (first_in_block_ || begin <= last_end_) return;
  BIP_ASSERT(begin <= source_.size(), "byte {} of {}", begin, source_.size());
  const std::string_view gap = source_.substr(last_end_, begin - last_end_);
  if (std::count(gap.begin(), gap.end(), '\n') >= 2 && out_.substr(out_.size() >= 2 ? out_.size() - 2 : 0) != "\n\n")
    out_ += '\n';
}

/// The comment with its inner lines re-indented if they begin with `*`, verbatim otherwise; no trailing blanks.
std::string SyntaxPrinter::comment_text(const Comment& c) const {
  BIP_ASSERT(c.range.begin < c.range.end && c.range.end <= source_.size(), "a comment from {} to {}", c.range.begin,
             c.range.end);
  std::string_view rest = source(c.range);
  std::string result;
  bool first = true;
  while (true) {
    const std::size_t cut = rest.find('\n');
    std::string_view line = rest.substr(0, cut);
    while (!line.empty() && (line.back() == ' ' || line.back() == '\t' || line.back() == '\r')) line.remove_suffix(1);
    if (!first) {
      result += '\n';
      const std::size_t start = line.find_first_not_of(" \t");
      if (start != std::string_view::npos && line[start] == '*') {
        result.append(static_cast<std::size_t>(indent_) * 2 + 1, ' ');
        line.remove_prefix(start);
      }
    }
    result += line;
    first = false;
    if (cut == std::string_view::npos) return result;
    rest.remove_prefix(cut + 1);
  }
}

void SyntaxPrinter::comment_line(const Comment& c) {
  blank_line_if_source_has_one(c.range.begin);
  begin_line();
  out_ += comment_text(c);
  out_ += '\n';
  last_end_ = std::max(last_end_, c.range.end);
}

/// The comments before something that begins at `begin`, and those inside it up to `limit`; then its blank line.
void SyntaxPrinter::lead_in(std::uint32_t begin, std::uint32_t limit) {
  while (has_comment_before(std::max(begin, limit))) comment_line(syntax_.comments[next_comment_++]);
  if (begin < source_.size()) blank_line_if_source_has_one(begin);
}

/// Ends the line, with the comments that follow on the same line of the source.
void SyntaxPrinter::end_line(std::uint32_t source_end) {
  BIP_ASSERT(source_end <= source_.size() && !out_.empty(), "a line ends at {} of {} bytes", source_end,
             source_.size());
  last_end_ = std::max(last_end_, source_end);
  bool is_full = false;
  // Comments inside what was printed, for which there was no room earlier.
  while (!is_full && has_comment_before(source_end)) {
    const Comment& c = syntax_.comments[next_comment_++];
    out_ += "  ";
    out_ += comment_text(c);
    is_full = source(c.range).substr(0, 2) == "//";
  }
  while (!is_full && next_comment_ < syntax_.comments.size()) {
    const Comment& c = syntax_.comments[next_comment_];
    if (c.range.begin < last_end_) break;
    const std::string_view gap = source_.substr(last_end_, c.range.begin - last_end_);
    if (gap.find_first_not_of(" \t;,)}") != std::string_view::npos) break;
    out_ += "  ";
    out_ += comment_text(c);
    last_end_ = c.range.end;
    ++next_comment_;
    if (source(c.range).substr(0, 2) == "//") break;
  }
  out_ += '\n';
  while (has_comment_before(source_end)) comment_line(syntax_.comments[next_comment_++]);
}

/// Ends the first line of a declaration and opens its block.
void SyntaxPrinter::header_line(std::uint32_t name_end) {
  if (has_comment_before(static_cast<std::uint32_t>(std::min(source_.find('\n', name_end), source_.size())))) {
    const Comment& c = syntax_.comments[next_comment_++];
    out_ += "  ";
    out_ += comment_text(c);
    last_end_ = c.range.end;
  } else {
    last_end_ = std::max(last_end_, name_end);
  }
  out_ += '\n';
  ++indent_;
  first_in_block_ = true;
}

/// The comments left before the `end` of a block, and the end itself.
void SyntaxPrinter::end_block(std::uint32_t source_end) {
  while (has_comment_before(source_end)) comment_line(syntax_.comments[next_comment_++]);
  --indent_;
  BIP_ASSERT(indent_ >= 0, "a block ends at indentation {}", indent_);
  begin_line();
  put("end");
  end_line(source_end);
}

void SyntaxPrinter::annotations(Annotations list, std::uint32_t begin) {
  for (const Annotation& a : list) {
    lead_in(a.range.begin, a.range.end);
    begin_line();
    put(text(a));
    end_line(a.range.end);
  }
  if (list.empty()) return;
  while (has_comment_before(begin)) comment_line(syntax_.comments[next_comment_++]);
  last_end_ = std::max(last_end_, begin);
}

}  // namespace bip::syntax
