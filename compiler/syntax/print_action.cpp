// Prints actions: on the line of their transition if they are short and plain, otherwise one statement per line.
#include "compiler/syntax/printer.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::syntax {
namespace {
constexpr std::size_t kLineWidth = 110;
}

/// ` do { … }` and the like, appended to the current line.
void SyntaxPrinter::block(std::string_view word, const Block& b) {
  if (!b.present) return;
  out_.append(" ").append(word);
  const bool has_comments = has_comment_before(b.range.end);
  if (!has_comments) {
    std::string line;
    bool plain = true;
    for (const Stmt* s : b.stmts) {
      plain = plain && is_simple(*s);
      if (plain) line += " " + simple(*s) + ";";
    }
    if (plain && (column() + line.size() <= kLineWidth || b.stmts.empty())) {
      out_ += b.stmts.empty() ? " {}" : " {" + line + " }";
      return;
    }
  }
  out_ += " {\n";
  ++indent_;
  first_in_block_ = true;
  last_end_ = std::max(last_end_, b.range.begin);
  stmts(b.stmts);
  while (has_comment_before(b.range.end)) comment_line(syntax_.comments[next_comment_++]);
  --indent_;
  begin_line();
  out_ += "}";
}

void SyntaxPrinter::stmts(std::span<const Stmt* const> list) {
  for (const Stmt* s : list) stmt(*s);
}

void SyntaxPrinter::stmt(const Stmt& s) {
  const bool is_one_line = is_simple(s);
  lead_in(s.range.begin, is_one_line ? s.range.end : s.range.begin);
  if (!is_one_line) return if_chain(s);
  begin_line();
  put(simple(s) + ";");
  end_line(s.range.end);
}

// Each `if` of the chain that had a `fi` of its own keeps it: the published tools know no other.
void SyntaxPrinter::if_chain(const Stmt& s) {
  BIP_ASSERT(parts_of(s) == StmtParts::Bodies, "no `if` at {}", s.range.begin);
  begin_line();
  const Stmt* at = &s;
  std::string ends = "fi";
  while (true) {
    put(std::string(info_of(at->kind).before) + "(" + text(at->value, Parentheses::Dropped) + ") then");
    header_line(at->value->range.end);
    stmts(at->then_body);
    --indent_;
    if (at->else_body.empty()) break;
    begin_line();
    if (at->else_body.size() == 1 && at->else_body[0]->kind == StmtKind::If) {
      put("else ");
      at = at->else_body[0];
      if (!at->shares_fi) ends += " fi";
      continue;
    }
    put("else\n");
    ++indent_;
    first_in_block_ = true;
    last_end_ = std::max(last_end_, at->else_body.front()->range.begin);
    stmts(at->else_body);
    --indent_;
    break;
  }
  ++indent_;
  while (has_comment_before(s.range.end)) comment_line(syntax_.comments[next_comment_++]);
  --indent_;
  begin_line();
  put(ends);
  end_line(s.range.end);
}

}  // namespace bip::syntax
