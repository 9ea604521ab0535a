// Details on the line of a node: expressions with every operator in parentheses and in one spelling, paths, names.
#include <iterator>

#include "compiler/base/quote.hpp"
#include "compiler/syntax/dump_syntax.hpp"

namespace bip::syntax {
namespace {

#define BIP_OP_SYMBOL(name, family, text, word, symbol, ...) symbol,
constexpr std::string_view kBinary[] = {BIP_BINARY_OPS(BIP_OP_SYMBOL)};
constexpr std::string_view kUnary[] = {BIP_SIGN_OPS(BIP_OP_SYMBOL) "+"};
#undef BIP_OP_SYMBOL
static_assert(std::size(kUnary) == static_cast<std::size_t>(UnaryOp::Plus) + 1, "a sign for each unary operator");

}  // namespace

std::string Dumper::text(const Path& p) {
  std::string out;
  for (const PathPart& part : p.parts) {
    if (!out.empty()) out += '.';
    out += part.name.text;
    if (part.star) out += "[*]";
    if (part.index != nullptr) out += "[" + text(part.index) + "]";
  }
  return out;
}

std::string Dumper::text(const TypeRef& t) { return (t.is_const ? "const " : "") + text(t.name); }

std::string Dumper::text(const Expr* e) {
  if (e == nullptr) return "?";
  switch (e->kind) {
    case ExprKind::Int:
    case ExprKind::Float:
    case ExprKind::Report: return std::string(e->text);
    case ExprKind::Bool: return e->truth ? "true" : "false";
    case ExprKind::String: return quoted(e->text);
    case ExprKind::Path: return text(e->path) + (e->clock_speed ? "'" : "");
    case ExprKind::Unary:
      return std::string("(").append(kUnary[static_cast<std::size_t>(e->unary)]) + text(e->operands[0]) + ")";
    case ExprKind::Binary:
      return "(" + text(e->operands[0]) + " " + std::string(kBinary[static_cast<std::size_t>(e->binary)]) + " " +
             text(e->operands[1]) + ")";
    case ExprKind::Call: break;
  }
  std::string out = text(e->path) + "(";
  for (std::size_t i = 0; i < e->operands.size(); ++i) out += (i > 0 ? ", " : "") + text(e->operands[i]);
  return out + ")";
}

std::string Dumper::text(const PortExpr& e) {
  const std::string prime = e.trigger ? "'" : "";
  if (e.kind == PortExprKind::Port) return text(e.port) + prime;
  std::string out;
  for (const PortExpr* child : e.children) out += (out.empty() ? "" : " ") + text(*child);
  return "(" + out + ")" + prime;
}

std::string Dumper::text(const InteractionPattern& p) {
  if (p.any_connector) return "*:*";
  if (p.any_interaction) return text(p.connector) + ":*";
  std::string out;
  for (const Path& port : p.ports) out += (out.empty() ? "" : ",") + text(port);
  return text(p.connector) + ":" + out;
}

std::string Dumper::names(std::span<const Name> list) {
  std::string out;
  for (const Name& n : list) out.append(out.empty() ? "" : ",").append(n.text);
  return "(" + out + ")";
}

std::string Dumper::guard(const Expr* e) { return e == nullptr ? std::string() : " provided " + text(e); }

}  // namespace bip::syntax
