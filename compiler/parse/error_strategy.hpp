// Reports syntax errors in BIP's words and recovers at items and declarations, instead of ANTLR's strategy.
//
// An error inside an item discards that item; the rest of its declaration is parsed. A missing `end` or closing bracket
// is reported once and then assumed. At most one error is reported per line, because further ones are nearly always
// consequences. A missing token is reported after the last token before it, not at the next one, which may be lines
// below.
#pragma once
#include <memory>
#include <set>
#include <string_view>
#include <vector>

#include "antlr4-runtime.h"
#include "compiler/diag/diagnostics.hpp"

namespace bip::parse {

class ReportingStrategy final : public antlr4::DefaultErrorStrategy {
 public:
  ReportingStrategy(const SourceMap& sources, FileId file, Diagnostics& diags);

  void reportError(antlr4::Parser* parser, const antlr4::RecognitionException& e) override;
  void recover(antlr4::Parser* parser, std::exception_ptr e) override;
  antlr4::Token* recoverInline(antlr4::Parser* parser) override;
  void sync(antlr4::Parser* parser) override;

 private:
  [[nodiscard]] static bool is_like_named_port(antlr4::Parser* parser, const antlr4::Token* found);
  [[nodiscard]] bool names_class_of_function(antlr4::Parser* parser, const antlr4::Token* found) const;
  void report_unexpected(antlr4::Parser* parser, const antlr4::Token* found, const antlr4::misc::IntervalSet& expected);
  /// Adds what a person may have meant; false if nothing is known.
  bool add_habit(antlr4::Parser* parser, const antlr4::Token* found, DiagnosticBuilder diagnostic);
  bool add_line_comment(const antlr4::Token* found, DiagnosticBuilder diagnostic);
  bool add_missing_fi(antlr4::Parser* parser, const antlr4::Token* found, DiagnosticBuilder diagnostic);
  [[nodiscard]] bool is_misspelled_end(antlr4::Parser* parser, const antlr4::Token* found) const;
  bool report_missing_closer(antlr4::Parser* parser, std::size_t closer);
  /// In the list of a declaration's items: reports what begins none of them and skips to one that does.
  bool skip_stray_words(antlr4::Parser* parser, const antlr4::misc::IntervalSet& expected);
  void note_skipped_to_end(antlr4::Parser* parser);
  antlr4::Token* conjure(antlr4::Parser* parser, std::size_t type);
  void report_missing_end(antlr4::Parser* parser, const antlr4::Token* found);
  /// False if this was reported, or something on its line, or on the line before it a string or comment without end.
  [[nodiscard]] bool is_first_report_at(antlr4::Parser* parser, const antlr4::Token* token);
  [[nodiscard]] bool is_first_of_line(antlr4::Parser* parser, const antlr4::Token* token) const;
  [[nodiscard]] std::size_t column(const antlr4::Token* token) const;
  /// Where something is missing: after the token before `found` if that is on an earlier line, else at `found`.
  [[nodiscard]] SourceRange missing_before(antlr4::Parser* parser, const antlr4::Token* found) const;
  [[nodiscard]] SourceRange range(const antlr4::Token* token) const;
  [[nodiscard]] std::string found_phrase(const antlr4::Token* token) const;

  std::string_view text_;
  FileId file_;
  Diagnostics& diags_;
  std::size_t last_reported_ = static_cast<std::size_t>(-1);
  std::set<std::size_t> told_lines_;
  std::set<std::size_t> lexical_lines_;  // with a string without end, and the like: the next line, too, reads wrong
  bool in_inline_connector_ = false;     // the last error: `define` and `on` that follow are the connector's
  std::size_t conjured_closer_ = 0, conjured_at_ = 0;  // type, index of the token it stands before
  std::size_t furthest_error_ = 0;
  bool is_end_lost_ = false;  // in a comment without end
  std::vector<std::unique_ptr<antlr4::CommonToken>> conjured_;
};

}  // namespace bip::parse
