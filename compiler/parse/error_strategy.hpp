// Reporting and recovery in place of ANTLR's: messages in BIP's words, recovery at items and declarations.
//
// An error inside an item unwinds to that item, which is left out; the rest of its declaration is still read. A missing
// `end` or closing bracket is reported once and then assumed.
#pragma once
#include <memory>
#include <string_view>
#include <vector>

#include "antlr4-runtime.h"
#include "compiler/diag/diagnostics.hpp"

namespace bip::parse {

class ReportingStrategy final : public antlr4::DefaultErrorStrategy {
 public:
  ReportingStrategy(const SourceMap& sources, FileId file, Diagnostics& diags)
      : text_(sources.text(file)), file_(file), diags_(diags) {}

  void reportError(antlr4::Parser* parser, const antlr4::RecognitionException& e) override;
  void recover(antlr4::Parser* parser, std::exception_ptr e) override;
  antlr4::Token* recoverInline(antlr4::Parser* parser) override;
  void sync(antlr4::Parser* parser) override;

 private:
  void report_unexpected(antlr4::Parser* parser, const antlr4::Token* found, const antlr4::misc::IntervalSet& expected);
  bool report_missing_closer(antlr4::Parser* parser, std::size_t closer);
  /// In the list of a declaration's items: reports what begins none of them and skips to one that does.
  bool skip_stray_words(antlr4::Parser* parser, const antlr4::misc::IntervalSet& expected);
  void note_skipped_to_end(antlr4::Parser* parser);
  antlr4::Token* conjure(antlr4::Parser* parser, std::size_t type);
  [[nodiscard]] bool is_first_report_at(std::size_t token_index);
  [[nodiscard]] SourceRange range(const antlr4::Token* token) const;
  [[nodiscard]] std::string found_phrase(const antlr4::Token* token) const;

  std::string_view text_;
  FileId file_;
  Diagnostics& diags_;
  std::size_t last_reported_ = static_cast<std::size_t>(-1);
  std::size_t furthest_error_ = 0;
  std::vector<std::unique_ptr<antlr4::CommonToken>> conjured_;
};

}  // namespace bip::parse
