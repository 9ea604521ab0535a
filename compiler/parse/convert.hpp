// Converts ANTLR's parse tree to syntax::Syntax, with the checks that the permissive grammar omits.
//
// Contexts with an exception (text that could not be parsed) are skipped. Nodes are allocated in an arena; names are
// views into the source. The tree is at most kMaxDepth deep (B0008 otherwise), whatever its width.
#pragma once
#include <string>
#include <vector>

#include "BipParser.h"
#include "antlr4-runtime.h"
#include "compiler/diag/diagnostics.hpp"
#include "compiler/parse/tree_arena.hpp"
#include "compiler/syntax/syntax.hpp"

namespace bip::parse {

using antlr::BipParser;

class Converter {
 public:
  Converter(const SourceMap& sources, FileId file, TreeArena arena, Diagnostics& diags)
      : text_(sources.text(file)), file_(file), arena_(arena), diags_(diags) {}

  const syntax::Package* file(BipParser::FileContext* ctx);
  /// May be null: reported.
  const syntax::Expr* expr(BipParser::ExprContext* ctx);

 private:
  friend class PieceReader;

  enum class Assigning : std::uint8_t { Compares, Forbidden, NamesArgument };
  struct Built {
    const syntax::Expr* expr = nullptr;
    int depth = 0;
  };
  /// What the items of a declaration are gathered into, before they become spans.
  struct Items {
    std::vector<syntax::DataDecl> data;
    std::vector<syntax::PortDecl> ports;
    std::vector<syntax::ClockDecl> clocks;
    std::vector<syntax::Name> places;
    syntax::Initial initial;
    std::vector<syntax::Transition> transitions;
    std::vector<syntax::AtomPriority> atom_priorities;
    std::vector<syntax::FinalPlaces> finals;
    std::vector<syntax::Invariant> invariants;
    std::vector<const syntax::CompoundItem*> items;
    std::vector<syntax::CompoundPriority> priorities;
    std::vector<syntax::CompoundExport> exports;
    bool has_behavior = false;
  };
  /// The declaration whose items are read: decides what may stand in it and how guards compare.
  struct Owner {
    std::string phrase;
    syntax::DeclKind kind = syntax::DeclKind::AtomType;
    syntax::Notation notation = syntax::Notation::Bip2;
    bool is_inline_connector = false;
  };

  // convert_expr.cpp
  Built build(BipParser::ExprContext* ctx, Assigning assigning);
  Built build_spine(BipParser::ExprContext* ctx, Assigning assigning);
  Built build_primary(BipParser::PrimaryContext* ctx, Assigning assigning);
  Built limited(Built built, SourceRange range);
  const syntax::Expr* guard(BipParser::ProvidedContext* ctx);
  [[nodiscard]] bool is_when(BipParser::ProvidedContext* ctx) const;
  const syntax::Expr* both(BipParser::ProvidedContext* first, BipParser::ProvidedContext* second);
  void add_resets(BipParser::ClockResetContext* ctx, syntax::Block& action);
  const syntax::Expr* value(BipParser::ExprContext* ctx);
  std::span<const syntax::NamedArg> named_args(BipParser::ArgsContext* ctx);
  void check_operator(const syntax::Expr& e, Assigning assigning, bool is_assign_sign);

  // convert_stmt.cpp
  syntax::Block block(BipParser::BlockContext* ctx);
  syntax::Block action(BipParser::ActionContext* ctx);
  std::span<const syntax::Stmt* const> stmts(BipParser::StmtsContext* ctx);
  const syntax::Stmt* simple(BipParser::SimpleContext* ctx);
  bool chains(BipParser::SimpleContext* ctx);
  const syntax::Stmt* if_stmt(BipParser::IfStmtContext* ctx);

  // convert_names.cpp
  [[nodiscard]] SourceRange range(const antlr4::Token* token) const;
  [[nodiscard]] SourceRange range(const antlr4::ParserRuleContext* ctx) const;
  [[nodiscard]] SourceRange range(const antlr4::Token* first, const antlr4::ParserRuleContext* last) const;
  [[nodiscard]] std::string_view text(SourceRange r) const { return text_.substr(r.begin, r.end - r.begin); }
  /// The parser found something wrong in the declaration: what seems to be missing or misplaced in it is a consequence.
  bool is_broken(SourceRange declaration);
  [[nodiscard]] static bool failed(const antlr4::ParserRuleContext* ctx) {
    return ctx == nullptr || ctx->exception != nullptr;
  }
  syntax::Name name(const antlr4::Token* token) const;
  syntax::Name name(BipParser::IdContext* ctx) const;
  std::span<const syntax::Name> names(BipParser::IdListContext* ctx);
  std::span<const syntax::Name> names(const std::vector<BipParser::IdContext*>& ids);
  syntax::Path path(BipParser::PathContext* ctx);
  syntax::Path path(BipParser::PortPathContext* ctx);
  syntax::Path path(BipParser::FamilyContext* ctx);
  syntax::PathPart part(BipParser::PathPartContext* ctx);
  enum class Constness : std::uint8_t { Mutable, Const };
  static Constness constness(const antlr4::tree::TerminalNode* keyword) {
    return keyword != nullptr ? Constness::Const : Constness::Mutable;
  }
  syntax::TypeRef type_ref(BipParser::TypeNameContext* ctx, Constness constness);
  std::string_view string(antlr4::tree::TerminalNode* node);
  syntax::Annotations annotations(const std::vector<BipParser::AnnotationContext*>& list);
  std::span<const syntax::Param> params(BipParser::ParamsContext* ctx);
  std::span<const syntax::Var> vars(const std::vector<BipParser::VarContext*>& list);
  syntax::DataDecl data(BipParser::DataDeclContext* ctx, syntax::Annotations annotations);

  // convert_decl.cpp
  const syntax::Decl* decl(BipParser::DeclContext* ctx);
  syntax::Decl extern_decl(BipParser::DeclContext* ctx);
  std::span<const syntax::Param> proto_params(const std::vector<BipParser::ProtoParamContext*>& list);
  syntax::Decl body_decl(syntax::Decl d, std::string_view what, const std::vector<BipParser::BodyItemContext*>& list);
  void open_body(const syntax::Decl& d, std::string_view what);
  void close_body(syntax::Decl& d, const Items& items);
  void check_body(const syntax::Decl& d, const Items& items);
  void missing_places(const syntax::Decl& d, const Items& items);
  void missing_initial(const syntax::Decl& d, const Items& items);
  void missing_define(const syntax::Decl& d);
  /// The end of line and the blanks with which a line begins that stands below the one at `offset`.
  [[nodiscard]] std::string line_like(std::uint32_t offset) const;
  void misplaced(std::string_view what, SourceRange at);

  // convert_connector.cpp
  const syntax::ConnectorBody* connector_body(const std::vector<BipParser::ConnectorPartContext*>& parts);
  const syntax::PortExpr* define(BipParser::DefineContext* ctx, syntax::Name& resume);
  const syntax::PortExpr* port_term(BipParser::PortTermContext* ctx);
  syntax::Clause clause(BipParser::ClauseContext* ctx, syntax::Annotations annotations);
  void repeated(std::string_view part, std::string_view whole, SourceRange at);

  // convert_atom.cpp
  void body_item(BipParser::BodyItemContext* ctx, Items& to);
  void atom_item(BipParser::BodyItemContext* ctx, syntax::Annotations annotations, Items& to);
  void behavior(BipParser::BehaviorContext* ctx, Items& to);
  syntax::PortDecl port(BipParser::PortDeclContext* ctx, syntax::Annotations annotations);
  syntax::Initial initial(BipParser::InitialContext* ctx);
  void transition(BipParser::TransitionContext* ctx, syntax::Annotations annotations, const syntax::Name* state,
                  Items& to);
  void atom_priority(BipParser::PriorityContext* ctx, Items& to);
  syntax::Invariant invariant(BipParser::InvariantContext* ctx);
  void missing_from_or_to(BipParser::TransitionContext* ctx, std::string_view word);
  void check_from_of_state(BipParser::FromContext* from, const syntax::Name& state);

  // convert_compound.cpp
  bool compound_item(BipParser::BodyItemContext* ctx, syntax::Annotations annotations, Items& to);
  void instances(const std::vector<BipParser::InstanceContext*>& list, BipParser::PathContext* type, SourceRange at,
                 syntax::Annotations annotations, Items& to);
  void bindings(BipParser::ConnectorDeclContext* ctx, syntax::Annotations annotations, Items& to);
  void inline_connector(BipParser::InlineConnectorContext* ctx, syntax::Annotations annotations, Items& to);
  void bound_ports(BipParser::BoundPortsContext* ctx, std::vector<syntax::Path>& to);
  void property(BipParser::PropertyDeclContext* ctx, syntax::Annotations annotations, Items& to);
  void for_items(BipParser::ForItemsContext* ctx, syntax::Annotations annotations, Items& to);
  syntax::CompoundPriority compound_priority(BipParser::PriorityContext* ctx, syntax::Annotations annotations);
  syntax::InteractionPattern pattern(BipParser::PrioritySideContext* ctx);

  std::string_view text_;
  FileId file_;
  TreeArena arena_;
  Diagnostics& diags_;
  Owner owner_;
  std::pair<std::uint32_t, std::string_view> misplaced_{0, {}};  // where the declaration begins, what
  SourceRange declaration_{};                                    // the one that is being converted
  std::vector<std::uint32_t> broken_;                            // where the parser found something wrong, sorted
  bool has_broken_ = false;
};

}  // namespace bip::parse
