// ANTLR's tree of a file of BIP1 to `syntax::bip1::Model`. C code is lexed and parsed once more by the rules of its
// part of the grammar; code that these do not take has its text only.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "Bip1Parser.h"
#include "compiler/parse/token_list.hpp"
#include "compiler/syntax/bip1.hpp"

namespace bip::parse {

/// The tokens of a part of a BIP1 text, comments apart. Words that are names where no construct begins with them are
/// names here.
[[nodiscard]] TokenList read_bip1_tokens(std::string_view part, std::uint32_t begin);
/// Deepest nesting that is read. What is written of it, with parentheses of its own, is less deep than kMaxDepth.
inline constexpr int kMaxBip1Depth = 200;
/// False if a tree of these tokens could be deeper; `deep` is then the first token beyond.
[[nodiscard]] bool is_flat_bip1(const std::vector<TokenRow>& rows, TokenRow& deep);

class Bip1Converter {
 public:
  Bip1Converter(std::string_view text, FileId file, std::vector<syntax::Comment>& comments)
      : text_(text), file_(file), comments_(comments) {}
  syntax::bip1::Model model(antlr::Bip1Parser::FileContext* ctx);

 private:
  using Parser = antlr::Bip1Parser;

  // declarations
  syntax::bip1::Decl port_type(Parser::PortTypeContext* ctx);
  syntax::bip1::Decl connector_type(Parser::ConnectorTypeContext* ctx);
  syntax::bip1::Decl atom_type(Parser::AtomTypeContext* ctx);
  syntax::bip1::Decl compound_type(Parser::CompoundTypeContext* ctx);
  syntax::bip1::ConnectorBody connector_body(const std::vector<Parser::ConnectorPartContext*>& parts);
  syntax::bip1::PortTerm port_term(Parser::PortTermContext* ctx);
  syntax::bip1::Completeness completeness(Parser::CompletenessContext* ctx);
  syntax::bip1::Clause clause(Parser::ClauseContext* ctx);
  syntax::bip1::Port port(Parser::PortDeclContext* ctx);
  void behavior(Parser::BehaviorContext* ctx, syntax::bip1::Decl& to);
  syntax::bip1::Initial initial(Parser::InitialContext* ctx);
  syntax::bip1::Transition transition(Parser::TransitionContext* ctx);
  syntax::bip1::When when(Parser::WhenContext* ctx);
  syntax::bip1::Instances instances(Parser::InstancesContext* ctx);
  void typed_connectors(Parser::ConnectorsContext* ctx, syntax::bip1::Decl& to);
  syntax::bip1::Connector inline_connector(Parser::InlineConnectorContext* ctx);
  syntax::bip1::Priority priority(Parser::PriorityContext* ctx);
  syntax::bip1::PrioritySide side(Parser::PrioritySideContext* ctx);
  syntax::bip1::Export compound_export(Parser::CompoundExportContext* ctx);

  // C code
  syntax::bip1::Code code(Parser::BlockContext* ctx);
  syntax::bip1::Code code(Parser::ActionContext* ctx);
  syntax::bip1::Guard guard(Parser::GuardContext* ctx);
  syntax::bip1::Guard guard(Parser::ExprContext* ctx);
  syntax::bip1::Data data(Parser::DataContext* ctx);
  bool declarations(SourceRange code, std::vector<syntax::bip1::Var>& to);
  bool statement(Parser::StmtContext* ctx, std::vector<syntax::bip1::Stmt>& to);
  bool simple(Parser::SimpleContext* ctx, std::vector<syntax::bip1::Stmt>& to);
  bool block(Parser::BlockContext* ctx, std::vector<syntax::bip1::Stmt>& to);
  bool statements(SourceRange code, std::vector<syntax::bip1::Stmt>& to);
  std::optional<syntax::bip1::Expr> expr(Parser::ExprContext* ctx);
  std::optional<syntax::bip1::Expr> operand(Parser::ExprContext* ctx);
  std::optional<syntax::bip1::Expr> primary(Parser::PrimaryContext* ctx);
  /// Parses `code` by `rule` and converts it while its tree lives; false if the rule does not take it.
  template <class Rule, class Convert>
  bool with_code(SourceRange code, Rule rule, Convert convert);

  // names and places
  [[nodiscard]] SourceRange range(const antlr4::Token* token) const;
  [[nodiscard]] SourceRange range(const antlr4::ParserRuleContext* ctx) const;
  [[nodiscard]] SourceRange inside(Parser::BlockContext* ctx) const;
  [[nodiscard]] std::string_view text(SourceRange r) const { return text_.substr(r.begin, r.end - r.begin); }
  syntax::Name name(Parser::IdContext* ctx) const;
  syntax::bip1::Names names(const std::vector<Parser::IdContext*>& ids) const;
  syntax::bip1::Names names(Parser::IdListContext* ctx) const;
  syntax::bip1::Path path(Parser::PathContext* ctx) const;
  std::vector<syntax::bip1::Path> paths(const std::vector<Parser::PathContext*>& list) const;
  syntax::bip1::Type type(Parser::TypeNameContext* ctx) const;
  std::vector<syntax::bip1::Param> params(Parser::ParamsContext* ctx);

  std::string_view text_;
  FileId file_;
  std::vector<syntax::Comment>& comments_;
  int nesting_ = 0;  // of blocks inside blocks
};

}  // namespace bip::parse
