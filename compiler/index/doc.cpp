// The text that a hover shows for a declaration: its line, and the comment directly above it.
#include <algorithm>

#include "compiler/index/index_builder.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::index {

using namespace syntax;

namespace {

constexpr std::size_t kLongestLine = 160;
constexpr std::size_t kLongestDoc = 4000;

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

// A comment's words: no slashes, no stars at the edges.
std::string words(std::string_view comment) {
  if (comment.starts_with("//")) {
    comment.remove_prefix(std::min(comment.find_first_not_of('/'), comment.size()));
    while (!comment.empty() && is_blank(comment.back())) comment.remove_suffix(1);
    return std::string(comment.starts_with(' ') ? comment.substr(1) : comment);
  }
  comment.remove_prefix(2);
  if (comment.ends_with("*/")) comment.remove_suffix(2);
  std::string out;
  while (!comment.empty()) {
    const std::size_t end = std::min(comment.find('\n'), comment.size());
    std::string_view line = comment.substr(0, end);
    comment.remove_prefix(std::min(end + 1, comment.size()));
    while (!line.empty() && (is_blank(line.front()) || line.front() == '*')) line.remove_prefix(1);
    while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
    if (!out.empty()) out += '\n';
    out += line;
  }
  while (!out.empty() && is_blank(out.back())) out.pop_back();
  return out.substr(std::min(out.find_first_not_of('\n'), out.size()));
}

}  // namespace

std::string IndexBuilder::doc_above(std::uint32_t begin, std::uint32_t /*end*/) const {
  const Syntax& syntax = *files_[file_].syntax;
  const std::string_view text = sources_.text(syntax.file);
  BIP_ASSERT(begin <= text.size(), "a declaration begins at {}, behind the end {} of its file", begin, text.size());
  auto next = std::upper_bound(syntax.comments.begin(), syntax.comments.end(), begin,
                               [](std::uint32_t at, const Comment& c) { return at < c.range.begin; });
  // Only what begins a line is above; a word before it on its line (`for … connector`) is part of the declaration.
  std::uint32_t upper = begin;
  while (upper > 0 && text[upper - 1] != '\n') --upper;
  std::string doc;
  while (next != syntax.comments.begin()) {
    const SourceRange at = std::prev(next)->range;
    if (at.end > upper) {
      --next;
      continue;
    }
    const std::string_view between = text.substr(at.end, upper - at.end);
    const bool touches =
        std::all_of(between.begin(), between.end(), is_blank) && std::count(between.begin(), between.end(), '\n') == 1;
    std::uint32_t line = at.begin;
    while (line > 0 && (text[line - 1] == ' ' || text[line - 1] == '\t')) --line;
    const bool is_alone = line == 0 || text[line - 1] == '\n';
    if (!touches || !is_alone || doc.size() > kLongestDoc) break;
    const std::string paragraph = words(text.substr(at.begin, at.end - at.begin));
    doc = doc.empty() ? paragraph : paragraph + "\n" + doc;
    upper = line;
    --next;
  }
  return doc;
}

std::string one_line(const SourceMap& sources, SourceRange range) {
  std::string out;
  const std::string_view text = sources.text(range);
  for (std::size_t at = 0; at < text.size() && out.size() <= kLongestLine;) {
    // A word, then a blank for all that follow it.
    std::size_t end = at;
    const std::size_t most = std::min(text.size(), at + kLongestLine + 1 - out.size());
    while (end < most && !is_blank(text[end])) ++end;
    out.append(text.substr(at, end - at));
    for (at = end; at < text.size() && is_blank(text[at]);) ++at;
    if (at != end && !out.empty() && out.size() <= kLongestLine) out += ' ';
  }
  if (out.size() <= kLongestLine) return out;
  // A cut keeps whole characters.
  while (!out.empty() && (static_cast<unsigned char>(out.back()) & 0xC0u) == 0x80u) out.pop_back();
  if (!out.empty()) out.pop_back();
  return out + "…";
}

std::string detail_of(const Symbol& symbol, const SourceMap& sources) {
  return symbol.detail.empty() ? one_line(sources, symbol.range) : symbol.detail;
}

std::string IndexBuilder::header(const Decl& d) const {
  if (d.kind != DeclKind::ConnectorType && d.kind != DeclKind::AtomType && d.kind != DeclKind::CompoundType)
    return one_line(sources_, d.range);
  std::string out = d.notation == Notation::Paper       ? "component "
                    : d.kind == DeclKind::ConnectorType ? "connector type "
                    : d.kind == DeclKind::AtomType      ? "atom type "
                                                        : "compound type ";
  out += d.name.text;
  if (d.notation == Notation::Paper && d.params.empty()) return out;
  out += '(';
  for (const Param& p : d.params) {
    if (&p != d.params.data()) out += ", ";
    if (p.type.is_written()) out += one_line(sources_, p.type.name.range) + " ";
    out += p.name.text;
  }
  return out + ")";
}

}  // namespace bip::index
