// Prints expressions, paths and lists. Operators keep their spelling (`&&`, `and`, `∧`), and parentheses are preserved.
// Recursion follows the depth of expressions, which the parser limits.
#include "compiler/base/quote.hpp"
#include "compiler/syntax/printer.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::syntax {

std::string SyntaxPrinter::text(const Path& p) const {
  std::string out;
  for (const PathPart& part : p.parts) {
    if (!out.empty()) out += '.';
    out += part.name.text;
    if (part.star) out += "[*]";
    if (part.index != nullptr) out += "[" + text(part.index) + "]";
  }
  return out;
}

std::string SyntaxPrinter::text(const TypeRef& t) const { return (t.is_const ? "const " : "") + text(t.name); }

std::string SyntaxPrinter::text(std::span<const Name> names) const {
  std::string out;
  for (const Name& n : names) {
    if (!out.empty()) out += ", ";
    out += n.text;
  }
  return out;
}

std::string SyntaxPrinter::text(std::span<const Path> paths, std::string_view separator) const {
  std::string out;
  for (const Path& p : paths) {
    if (!out.empty()) out += separator;
    out += text(p);
  }
  return out;
}

std::string SyntaxPrinter::text(std::span<const Param> params) const {
  std::string out;
  for (const Param& p : params) {
    if (!out.empty()) out += ", ";
    out += text(p.type);
    if (!p.name.text.empty()) out.append(" ").append(p.name.text);
  }
  return out;
}

std::string SyntaxPrinter::text(std::span<const Var> vars) const {
  std::string out;
  for (const Var& v : vars) {
    if (!out.empty()) out += ", ";
    out += v.name.text;
    if (v.init != nullptr) out += " = " + text(v.init);
  }
  return out;
}

std::string SyntaxPrinter::text(std::span<const NamedArg> args) const {
  std::string out;
  for (const NamedArg& a : args) {
    if (!out.empty()) out += ", ";
    if (!a.name.text.empty()) out.append(a.name.text).append(" = ");
    out += text(a.value);
  }
  return out;
}

std::string SyntaxPrinter::text(const Annotation& a) const {
  // As written, blanks outside strings reduced to one.
  std::string out;
  bool in_string = false;
  for (const char c : source(a.range)) {
    const bool blank = c == ' ' || c == '\t' || c == '\n' || c == '\r';
    if (c == '"' && (out.empty() || out.back() != '\\')) in_string = !in_string;
    if (blank && !in_string) {
      if (!out.empty() && out.back() != ' ') out += ' ';
    } else {
      out += c;
    }
  }
  return out;
}

std::string SyntaxPrinter::text(const Expr* e, Parentheses parentheses) const {
  if (e == nullptr) return {};
  std::string out;
  switch (e->kind) {
    case ExprKind::Int:
    case ExprKind::Float:
    case ExprKind::Report: out = e->text; break;
    case ExprKind::Bool: out = e->truth ? "true" : "false"; break;
    case ExprKind::String: out = quoted(e->text); break;
    case ExprKind::Path: out = text(e->path) + (e->clock_speed ? "'" : ""); break;
    case ExprKind::Unary: {
      const std::string_view sign = source(e->op_range);
      out.append(sign).append(sign == "not" ? " " : "");
      out += text(e->operands[0]);
      break;
    }
    case ExprKind::Binary: {
      // A chain a + b + c is a left spine: walked by a loop, printed from its innermost operand.
      std::vector<const Expr*> spine;
      const Expr* at = e;
      while (at->kind == ExprKind::Binary && (at == e || !at->parenthesised)) {
        BIP_ASSERT(at->operands.size() == 2, "an operator of {} operands", at->operands.size());
        spine.push_back(at);
        at = at->operands[0];
      }
      out = text(at);
      while (!spine.empty()) {
        // The older spelling of time writes `provided (data) when (clocks)`.
        const std::string_view sign = source(spine.back()->op_range);
        out.append(" ").append(sign == "when" ? "&&" : sign).append(" ");
        out += text(spine.back()->operands[1]);
        spine.pop_back();
      }
      break;
    }
    case ExprKind::Call: {
      out = text(e->path) + "(";
      for (std::size_t i = 0; i < e->operands.size(); ++i) {
        if (i > 0) out += ", ";
        out += text(e->operands[i]);
      }
      out += ")";
      break;
    }
  }
  return e->parenthesised && parentheses == Parentheses::Kept ? "(" + out + ")" : out;
}

std::string SyntaxPrinter::guard(const Expr* e) const {
  if (notation_ == Notation::Paper) return " provided " + text(e, Parentheses::Dropped);
  return " provided (" + text(e, Parentheses::Dropped) + ")";
}

std::string SyntaxPrinter::simple(const Stmt& s) const {
  BIP_ASSERT(is_simple(s) && s.value != nullptr, "a statement of several lines at {}", s.range.begin);
  const std::string value = std::string(info_of(s.kind).before) + text(s.value);
  if (parts_of(s) == StmtParts::ValueAlone) return value;
  return text(s.target) + (s.clock_speed ? "'" : "") + (notation_ == Notation::Paper ? " <- " : " = ") + value;
}

bool SyntaxPrinter::is_simple(const Stmt& s) { return parts_of(s) != StmtParts::Bodies; }

std::string SyntaxPrinter::text(const PortExpr& e, Level level) const {
  const std::string prime = e.trigger ? "'" : "";
  if (e.kind == PortExprKind::Port) return text(e.port) + prime;
  const bool paper = notation_ == Notation::Paper;
  std::string out;
  for (const PortExpr* child : e.children) {
    if (!out.empty()) out += paper ? ", " : " ";
    out += text(*child, Level::Inner);
  }
  if (paper) return "[" + out + "]" + prime;
  return level == Level::Root ? out : "(" + out + ")" + prime;
}

std::string SyntaxPrinter::text(const InteractionPattern& p) const {
  if (p.any_connector) return "*:*";
  if (p.any_interaction) return text(p.connector) + (notation_ == Notation::Paper ? "" : ":*");
  return text(p.connector) + ":" + text(p.ports, ",");
}

}  // namespace bip::syntax
