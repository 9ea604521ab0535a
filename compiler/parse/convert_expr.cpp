// Converts expressions. A chain a + b + c … is a left spine of the parse tree and is walked by a loop, so its length
// needs no stack; right operands, parentheses and arguments recurse and are bounded by check_depth.
#include <algorithm>

#include "compiler/parse/convert.hpp"
#include "compiler/parse/parse.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::parse {

using namespace syntax;

namespace {

BinaryOp binary_op(std::size_t type) {
#define BIP_OP_TOKEN(name, family, text, word, symbol, precedence, operands, result, function, promela, token) \
  case BipParser::token: return BinaryOp::name;
  switch (type) {
    BIP_BINARY_OPS(BIP_OP_TOKEN)
    case BipParser::OR_WORD: return BinaryOp::Or;
    case BipParser::AND_WORD: return BinaryOp::And;
    // A single `=`, reported elsewhere if it may not compare.
    case BipParser::ASSIGN: return BinaryOp::Eq;
    default: BIP_UNREACHABLE("the grammar has a binary operator that ops.def does not have");
  }
#undef BIP_OP_TOKEN
}

UnaryOp unary_op(std::size_t type) {
#define BIP_SIGN_TOKEN(name, family, text, word, symbol, precedence, operands, result, function, promela, token) \
  case BipParser::token: return UnaryOp::name;
  switch (type) {
    BIP_SIGN_OPS(BIP_SIGN_TOKEN)
    case BipParser::PLUS: return UnaryOp::Plus;
    case BipParser::NOT_WORD: return UnaryOp::Not;
    default: BIP_UNREACHABLE("the grammar has a unary operator that ops.def does not have");
  }
#undef BIP_SIGN_TOKEN
}

bool is_relational(const Expr& e) {
  return e.kind == ExprKind::Binary && !e.parenthesised &&
         (e.binary == BinaryOp::Lt || e.binary == BinaryOp::Gt || e.binary == BinaryOp::Le || e.binary == BinaryOp::Ge);
}

/// The only token among the children of an operator expression.
const antlr4::Token* sign_of(BipParser::ExprContext* ctx) {
  for (antlr4::tree::ParseTree* child : ctx->children) {
    if (auto* node = dynamic_cast<antlr4::tree::TerminalNode*>(child)) return node->getSymbol();
  }
  return ctx->start;
}

}  // namespace

const Expr* Converter::expr(BipParser::ExprContext* ctx) { return build(ctx, Assigning::Forbidden).expr; }
const Expr* Converter::value(BipParser::ExprContext* ctx) { return ctx == nullptr ? nullptr : expr(ctx); }

const Expr* Converter::guard(BipParser::ProvidedContext* ctx) {
  if (failed(ctx)) return nullptr;
  const bool paper = owner_.notation == Notation::Paper || owner_.is_inline_connector;
  return build(ctx->expr(), paper ? Assigning::Compares : Assigning::Forbidden).expr;
}

Converter::Built Converter::limited(Built built, SourceRange at) {
  if (built.depth <= kMaxDepth) return built;
  diags_.report(Diag::kB0008, at, kMaxDepth).help("name a part of it in a variable or a function of its own");
  return {};
}

Converter::Built Converter::build(BipParser::ExprContext* ctx, Assigning assigning) {
  if (failed(ctx)) return {};
  return build_spine(ctx, assigning);
}

Converter::Built Converter::build_spine(BipParser::ExprContext* ctx, Assigning assigning) {
  std::vector<BipParser::ExprContext*> spine;
  while (ctx->children.size() == 3) {
    spine.push_back(ctx);
    ctx = static_cast<BipParser::ExprContext*>(ctx->children[0]);
    if (failed(ctx)) return {};
  }
  Built left;
  if (BipParser::PrimaryContext* primary = ctx->primary()) {
    left = build_primary(primary, assigning);
  } else {
    const antlr4::Token* sign = sign_of(ctx);
    const Built operand = build(ctx->expr(0), assigning);
    if (operand.expr == nullptr) return {};
    Expr e{.kind = ExprKind::Unary, .range = range(ctx)};
    e.unary = unary_op(sign->getType());
    e.op_range = range(sign);
    e.operands = arena_.list(std::vector<const Expr*>{operand.expr});
    left = limited({arena_.make(e), operand.depth + 1}, e.range);
  }
  for (auto at = spine.rbegin(); at != spine.rend(); ++at) {
    if (left.expr == nullptr) return {};
    const antlr4::Token* sign = sign_of(*at);
    const Built right = build((*at)->expr(1), assigning);
    if (right.expr == nullptr) return {};
    Expr e{.kind = ExprKind::Binary, .range = {file_, left.expr->range.begin, right.expr->range.end}};
    e.binary = binary_op(sign->getType());
    e.op_range = range(sign);
    e.operands = arena_.list(std::vector<const Expr*>{left.expr, right.expr});
    check_operator(e, assigning, sign->getType() == BipParser::ASSIGN);
    left = limited({arena_.make(e), std::max(left.depth, right.depth) + 1}, e.range);
  }
  return left;
}

void Converter::check_operator(const Expr& e, Assigning assigning, bool is_assign_sign) {
  BIP_ASSERT(e.kind == ExprKind::Binary && e.operands.size() == 2, "an operator of {} operands", e.operands.size());
  const Expr& left = *e.operands[0];
  if (is_assign_sign && assigning != Assigning::Compares) {
    diags_.report(Diag::kB0011, e.op_range, "an expression").help("write `==` to compare", e.op_range, "==");
  }
  if (!is_relational(e) || !is_relational(left)) return;
  const std::string middle(text(left.operands[1]->range));
  const SourceRange rest{file_, e.op_range.begin, e.range.end};
  const std::string mended = " && " + middle + " " + std::string(text(rest));
  diags_.report(Diag::kB0010, e.op_range, text(left.range))
      .label(left.range, "true or false")
      .help("write `" + std::string(text(left.range)) + mended + "`", SourceRange{file_, left.range.end, e.range.end},
            mended);
}

Converter::Built Converter::build_primary(BipParser::PrimaryContext* ctx, Assigning assigning) {
  if (failed(ctx)) return {};
  Expr e{.kind = ExprKind::Path, .range = range(ctx)};
  int depth = 1;
  if (BipParser::ExprContext* inner = ctx->expr()) {
    const Built built = build(inner, assigning == Assigning::NamesArgument ? Assigning::Forbidden : assigning);
    if (built.expr == nullptr) return {};
    e = *built.expr;
    e.parenthesised = true;
    e.range = range(ctx);
    return {arena_.make(e), built.depth};
  }
  if (ctx->path() != nullptr) {
    e.path = path(ctx->path());
    e.clock_speed = ctx->PRIME() != nullptr;
    if (ctx->LPAREN() != nullptr) {
      e.kind = ExprKind::Call;
      std::vector<const Expr*> operands;
      for (BipParser::ExprContext* arg :
           ctx->args() == nullptr ? std::vector<BipParser::ExprContext*>() : ctx->args()->expr()) {
        const Built built = build(arg, Assigning::Forbidden);
        if (built.expr == nullptr) return {};
        depth = std::max(depth, built.depth + 1);
        operands.push_back(built.expr);
      }
      e.operands = arena_.list(operands);
    }
    return limited({arena_.make(e), depth}, e.range);
  }
  e.text = text(e.range);
  switch (ctx->start->getType()) {
    case BipParser::INT: e.kind = ExprKind::Int; break;
    case BipParser::FLOAT: e.kind = ExprKind::Float; break;
    case BipParser::REPORT: e.kind = ExprKind::Report; break;
    case BipParser::STRING:
      e.kind = ExprKind::String;
      e.text = string(ctx->STRING());
      break;
    default:
      e.kind = ExprKind::Bool;
      e.truth = ctx->TRUE() != nullptr;
      e.text = {};
  }
  return {arena_.make(e), 1};
}

std::span<const NamedArg> Converter::named_args(BipParser::ArgsContext* ctx) {
  std::vector<NamedArg> list;
  for (BipParser::ExprContext* arg : ctx == nullptr ? std::vector<BipParser::ExprContext*>() : ctx->expr()) {
    NamedArg to;
    // `x = 3` reads as a comparison in the grammar; here it names the argument.
    if (arg->children.size() == 3 && sign_of(arg)->getType() == BipParser::ASSIGN) {
      auto* left = static_cast<BipParser::ExprContext*>(arg->children[0]);
      BipParser::PrimaryContext* primary = left->primary();
      const bool is_name = primary != nullptr && primary->path() != nullptr && primary->start == primary->stop;
      if (is_name) {
        to.name = name(primary->start);
        arg = arg->expr(1);
      }
    }
    to.value = build(arg, Assigning::NamesArgument).expr;
    if (to.value != nullptr) list.push_back(to);
  }
  return arena_.list(list);
}

}  // namespace bip::parse
