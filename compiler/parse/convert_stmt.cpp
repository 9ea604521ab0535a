// Converts actions. An `else if` chain with one `fi` becomes nested ifs, as in the longer spelling.
#include "compiler/parse/convert.hpp"
#include "compiler/parse/describe_tokens.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::parse {

using namespace syntax;

Block Converter::block(BipParser::BlockContext* ctx) {
  if (failed(ctx)) return {.present = true, .stmts = {}, .range = {}};
  return {.present = true, .stmts = stmts(ctx->stmts()), .range = range(ctx)};
}

Block Converter::action(BipParser::ActionContext* ctx) {
  if (failed(ctx)) return {.present = true, .stmts = {}, .range = {}};
  if (ctx->block() != nullptr) return block(ctx->block());
  std::vector<const Stmt*> action;
  if (const Stmt* stmt = simple(ctx->simple())) action.push_back(stmt);
  return {.present = true, .stmts = arena_.list(action), .range = range(ctx->simple())};
}

std::span<const Stmt* const> Converter::stmts(BipParser::StmtsContext* ctx) {
  std::vector<const Stmt*> list;
  if (failed(ctx)) return {};
  antlr4::ParserRuleContext* unfinished = nullptr;
  for (antlr4::tree::ParseTree* child : ctx->children) {
    auto* rule = dynamic_cast<antlr4::ParserRuleContext*>(child);
    if (rule == nullptr) {
      unfinished = nullptr;
      continue;
    }
    if (unfinished != nullptr) {
      const SourceRange at = range(unfinished);
      const SourceRange after{file_, at.end, at.end};
      diags_.report(Diag::kB0012, at, "`" + std::string(text(range(rule->start))) + "`")
          .help("write `;` after it", after, ";");
    }
    const Stmt* stmt = nullptr;
    switch (rule->getRuleIndex()) {
      case BipParser::RuleIfStmt:
        unfinished = nullptr;
        stmt = if_stmt(static_cast<BipParser::IfStmtContext*>(rule));
        break;
      case BipParser::RuleSimple:
        unfinished = rule;
        stmt = simple(static_cast<BipParser::SimpleContext*>(rule));
        break;
      default: BIP_UNREACHABLE("a rule of the grammar's `stmts`");
    }
    if (stmt != nullptr) list.push_back(stmt);
  }
  return arena_.list(list);
}

const Stmt* Converter::simple(BipParser::SimpleContext* ctx) {
  if (failed(ctx)) return nullptr;
  Stmt stmt{.kind = StmtKind::Assign, .range = range(ctx)};
  if (ctx->LPAREN() != nullptr) {
    Expr call{.kind = ExprKind::Call, .range = range(ctx)};
    call.path = path(ctx->path());
    std::vector<const Expr*> operands;
    for (BipParser::ExprContext* arg :
         ctx->args() == nullptr ? std::vector<BipParser::ExprContext*>() : ctx->args()->expr()) {
      const Expr* operand = expr(arg);
      if (operand == nullptr) return nullptr;
      operands.push_back(operand);
    }
    call.operands = arena_.list(operands);
    stmt.kind = StmtKind::Call;
    stmt.value = arena_.make(call);
    return arena_.make(stmt);
  }
  if (ctx->LT() != nullptr) {
    const antlr4::Token* less = ctx->LT()->getSymbol();
    if (less->getStopIndex() != ctx->MINUS()->getSymbol()->getStartIndex()) {
      diags_.report(Diag::kB0001, range(less), "`=` or `<-`", " in a statement", "`<`");
    }
  }
  if (chains(ctx)) return nullptr;
  stmt.target = path(ctx->path());
  stmt.clock_speed = ctx->PRIME() != nullptr;
  stmt.value = expr(ctx->expr());
  return stmt.value == nullptr ? nullptr : arena_.make(stmt);
}

// `a = b = 0`, as in C.
bool Converter::chains(BipParser::SimpleContext* ctx) {
  BipParser::ExprContext* value = ctx->expr();
  if (failed(value) || value->ASSIGN() == nullptr || failed(value->expr(0))) return false;
  BipParser::PrimaryContext* first = value->expr(0)->primary();
  if (first == nullptr || first->path() == nullptr || first->LPAREN() != nullptr) return false;
  const std::string inner(text(range(value->expr(0))));
  const std::string two =
      std::string(text(range(value))) + "; " + std::string(text(range(ctx->path()))) + " = " + inner;
  diags_.report(Diag::kB0011, range(value->ASSIGN()->getSymbol()), "an expression")
      .help("write two assignments: `" + two + "`", range(ctx), two);
  return true;
}

const Stmt* Converter::if_stmt(BipParser::IfStmtContext* ctx) {
  if (failed(ctx)) return nullptr;
  const std::vector<BipParser::ExprContext*> conditions = ctx->expr();
  const std::vector<BipParser::StmtsContext*> bodies = ctx->stmts();
  const std::vector<antlr4::tree::TerminalNode*> ifs = ctx->IF();
  const std::uint32_t end = range(ctx).end;
  std::span<const Stmt* const> rest;
  if (bodies.size() > conditions.size()) rest = stmts(bodies.back());
  const Stmt* chained = nullptr;
  for (std::size_t i = conditions.size(); i-- > 0;) {
    const Expr* condition = expr(conditions[i]);
    const std::span<const Stmt* const> body = stmts(bodies[i]);
    if (condition == nullptr) return nullptr;
    Stmt stmt{.kind = StmtKind::If, .range = {file_, range(ifs[i]->getSymbol()).begin, end}};
    stmt.value = condition;
    stmt.then_body = body;
    stmt.else_body = rest;
    stmt.shares_fi = i > 0;
    chained = arena_.make(stmt);
    rest = arena_.list(std::vector<const Stmt*>{chained});
  }
  return chained;
}

}  // namespace bip::parse
