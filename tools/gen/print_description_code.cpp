// Expressions with as few parentheses as C's precedence allows (so that the parser's precedence is tested), statements,
// paths.
#include "tools/gen/print_description_code.hpp"

#include "tools/gen/ffi_prototypes.hpp"

namespace bip::gen {
namespace {

int precedence(const std::string& op) {
  if (op == "||") return 1;
  if (op == "&&") return 2;
  if (op == "|") return 3;
  if (op == "^") return 4;
  if (op == "&") return 5;
  if (op == "==" || op == "!=") return 6;
  if (op == "<" || op == ">" || op == "<=" || op == ">=") return 7;
  if (op == "+" || op == "-") return 8;
  return 9;
}
constexpr int kUnary = 10;
constexpr int kPrimary = 11;

// An operator on objects is written like any other.
bool is_operator(const Expr& expr) {
  return expr.kind == ExprKind::Binary ||
         (expr.kind == ExprKind::Call && ffi_functions()[static_cast<std::size_t>(expr.row)].is_operator);
}

int precedence(const Expr& expr) {
  if (is_operator(expr)) return precedence(expr.text);
  return expr.kind == ExprKind::Unary ? kUnary : kPrimary;
}

std::string operator_text(const std::string& op, Spelling spelling) {
  if (spelling == Spelling::Bip2) return op;
  if (op == "||") return "or";
  if (op == "&&") return "∧";
  if (op == "<=") return "≤";
  if (op == "!=") return "≠";
  if (op == "==" && spelling == Spelling::PaperGuard) return "=";
  return op;
}

std::string wrapped(const Expr& expr, bool parens, const NameText& names, Spelling spelling) {
  std::string text = text_of(expr, names, spelling);
  return parens && !expr.extra_parens ? "(" + text + ")" : text;
}

}  // namespace

std::string plain_name(const std::string& scope, const std::string& name) {
  return scope.empty() || scope == "$" ? name : scope + "." + name;
}

std::string text_of(const Expr& expr, const NameText& names, Spelling spelling) {
  std::string text;
  switch (expr.kind) {
    case ExprKind::Literal: text = expr.text; break;
    case ExprKind::Name: text = names(expr.scope, expr.name); break;
    case ExprKind::Unary: {
      // "- -x" would lex as "--x"; a nested unary keeps its parentheses.
      std::string operand = wrapped(expr.args[0], precedence(expr.args[0]) <= kUnary, names, spelling);
      text = expr.text + operand;
      break;
    }
    case ExprKind::Constant: text = names("", "$" + expr.text); break;
    case ExprKind::Draw:
      for (const Expr& arg : expr.args) text += (text.empty() ? "" : ", ") + text_of(arg, names, spelling);
      text = expr.text + "(" + text + ")";
      break;
    case ExprKind::Inline:
    case ExprKind::Call:
      if (!is_operator(expr)) {
        const std::size_t count = expr.args.size() - (expr.kind == ExprKind::Inline ? 1 : 0);
        for (std::size_t k = 0; k < count; ++k) text += (k == 0 ? "" : ", ") + text_of(expr.args[k], names, spelling);
        text = names("", "$" + expr.text) + "(" + text + ")";
        break;
      }
      [[fallthrough]];
    case ExprKind::Binary: {
      int mine = precedence(expr.text);
      // Comparison chains are errors, so comparisons inside comparisons keep their parentheses.
      bool comparison = mine == 6 || mine == 7;
      auto operand = [&](const Expr& e, bool right) {
        int other = precedence(e);
        bool nested = comparison && (other == 6 || other == 7);
        return wrapped(e, nested || other < mine || (right && other == mine), names, spelling);
      };
      text =
          operand(expr.args[0], false) + " " + operator_text(expr.text, spelling) + " " + operand(expr.args[1], true);
      break;
    }
  }
  return expr.extra_parens ? "(" + text + ")" : text;
}

namespace {
std::string statements(const Body& body, const NameText& names, Spelling spelling) {
  std::string text;
  for (const Stmt& stmt : body) {
    if (stmt.is_if) {
      text += "if (" + text_of(stmt.value, names, spelling) + ") then " + statements(stmt.then_body, names, spelling);
      if (!stmt.else_body.empty()) text += "else " + statements(stmt.else_body, names, spelling);
      text += "fi ";
    } else if (stmt.is_call) {
      text += text_of(stmt.value, names, spelling) + "; ";
    } else {
      const char* assign = spelling == Spelling::Bip2 ? " = " : " <- ";
      text += names(stmt.scope, stmt.name) + assign + text_of(stmt.value, names, spelling) + "; ";
    }
  }
  return text;
}
}  // namespace

std::string text_of(const Body& body, const NameText& names, Spelling spelling) {
  return "{ " + statements(body, names, spelling) + "}";
}

std::string text_of(const PortPath& path) {
  std::string text = path.component;
  switch (path.index.kind) {
    case Index::Kind::None: break;
    case Index::Kind::Constant: text += "[" + std::to_string(path.index.value) + "]"; break;
    case Index::Kind::Loop:
      text +=
          path.index.value == 0 ? "[i]" : "[(i + " + std::to_string(path.index.value) + ") % " + path.index.size + "]";
      break;
  }
  return text + "." + path.port;
}

std::string join(const std::vector<std::string>& items, const char* separator) {
  std::string text;
  for (const std::string& item : items) text += (text.empty() ? "" : separator) + item;
  return text;
}

}  // namespace bip::gen
