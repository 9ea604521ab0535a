// See translate_code.hpp. C takes numbers for truth values: `n` becomes `(n != 0)` where BIP2 wants one, and `b == 1`
// becomes `b == true`. Recursion is bounded by the parser.
#include "compiler/migrate/translate_code.hpp"

#include <algorithm>

#include "runtime/include/bip/assert.hpp"

namespace bip::migrate {

using namespace syntax::bip1;

namespace {

bool is_number(ValueKind kind) {
  return kind == ValueKind::Int || kind == ValueKind::Float || kind == ValueKind::Clock || kind == ValueKind::Unknown;
}
bool is_zero_or_one(const Expr& e) { return e.kind == ExprKind::Int && (e.text == "0" || e.text == "1"); }
std::string truth_of(const Expr& e) { return e.text == "1" ? "true" : "false"; }

/// The escapes that mean the same in both languages.
bool has_common_escapes(std::string_view literal) {
  for (std::size_t at = 0; at + 1 < literal.size(); ++at) {
    if (literal[at] != '\\') continue;
    if (std::string_view("nt\\\"").find(literal[at + 1]) == std::string_view::npos) return false;
    ++at;
  }
  return true;
}

}  // namespace

std::optional<std::string> CodeTranslator::value(const Expr& e, ValueKind want) const {
  if (want == ValueKind::Bool && is_zero_or_one(e)) return truth_of(e);
  std::optional<Value> made = any(e);
  if (!made) return std::nullopt;
  const ValueKind kind = made->kind;
  if (kind == want || want == ValueKind::Unknown || kind == ValueKind::Unknown) return made->text;
  if (want == ValueKind::Bool && (kind == ValueKind::Int || kind == ValueKind::Float))
    return "(" + made->text + " != 0)";
  const bool widens = (want == ValueKind::Float || want == ValueKind::Clock) && is_number(kind);
  return widens ? std::optional(made->text) : std::nullopt;
}

std::optional<CodeTranslator::Value> CodeTranslator::any(const Expr& e) const {
  switch (e.kind) {
    case ExprKind::Int: return Value{e.text, ValueKind::Int, ""};
    case ExprKind::Float: return Value{e.text, ValueKind::Float, ""};
    case ExprKind::Bool: return Value{e.text, ValueKind::Bool, ""};
    case ExprKind::String:
      return has_common_escapes(e.text) ? std::optional(Value{e.text, ValueKind::String, ""}) : std::nullopt;
    case ExprKind::Variable: {
      const auto found = variables_.find(joined(e.path));
      if (found == variables_.end()) return std::nullopt;
      return Value{names_.path(e.path), found->second.type.kind, found->second.type.cpp};
    }
    case ExprKind::Call: return std::nullopt;
    case ExprKind::Parenthesised: {
      std::optional<Value> inner = any(e.operands[0]);
      if (inner) inner->text = "(" + inner->text + ")";
      return inner;
    }
    case ExprKind::Unary: {
      BIP_ASSERT(e.operands.size() == 1, "a sign of {} operands", e.operands.size());
      if (e.text == "!") {
        const std::optional<std::string> inner = value(e.operands[0], ValueKind::Bool);
        return inner ? std::optional(Value{"!" + *inner, ValueKind::Bool, ""}) : std::nullopt;
      }
      std::optional<Value> inner = any(e.operands[0]);
      if (!inner || !is_number(inner->kind)) return std::nullopt;
      if (e.text == "~" && inner->kind != ValueKind::Int) return std::nullopt;
      // `- -1` must not become `--1`.
      inner->text = e.text + (inner->text.starts_with(e.text) ? " " : "") + inner->text;
      return inner;
    }
    case ExprKind::Binary: return binary(e);
  }
  return std::nullopt;
}

std::optional<CodeTranslator::Value> CodeTranslator::binary(const Expr& e) const {
  BIP_ASSERT(e.operands.size() == 2, "an operator of {} operands", e.operands.size());
  const std::string sign = " " + e.text + " ";
  if (e.text == "&&" || e.text == "||") {
    const std::optional<std::string> left = value(e.operands[0], ValueKind::Bool);
    const std::optional<std::string> right = value(e.operands[1], ValueKind::Bool);
    if (!left || !right) return std::nullopt;
    return Value{*left + sign + *right, ValueKind::Bool, ""};
  }
  if (std::string_view("==!=<=>=").find(e.text) != std::string_view::npos) return comparison(e);
  const std::optional<Value> left = any(e.operands[0]), right = any(e.operands[1]);
  if (!left || !right || !is_number(left->kind) || !is_number(right->kind)) return std::nullopt;
  const bool both_int = left->kind == ValueKind::Int && right->kind == ValueKind::Int;
  const bool is_known = left->kind != ValueKind::Unknown && right->kind != ValueKind::Unknown;
  if (std::string_view("%&|^").find(e.text) != std::string_view::npos && is_known && !both_int) return std::nullopt;
  const ValueKind kind = both_int ? ValueKind::Int : is_known ? ValueKind::Float : ValueKind::Unknown;
  return Value{left->text + sign + right->text, kind, ""};
}

std::optional<CodeTranslator::Value> CodeTranslator::comparison(const Expr& e) const {
  const std::string sign = " " + e.text + " ";
  const bool is_equality = e.text == "==" || e.text == "!=";
  const std::optional<Value> left = any(e.operands[0]), right = any(e.operands[1]);
  if (!left || !right) return std::nullopt;
  const auto made = [](std::string text) { return Value{std::move(text), ValueKind::Bool, ""}; };
  if (is_number(left->kind) && is_number(right->kind)) return made(left->text + sign + right->text);
  if (!is_equality) return std::nullopt;
  if (left->kind == ValueKind::Bool && is_zero_or_one(e.operands[1]))
    return made(left->text + sign + truth_of(e.operands[1]));
  if (right->kind == ValueKind::Bool && is_zero_or_one(e.operands[0]))
    return made(truth_of(e.operands[0]) + sign + right->text);
  const bool is_same = left->kind == right->kind && (left->kind == ValueKind::Bool || left->kind == ValueKind::String);
  return is_same ? std::optional(made(left->text + sign + right->text)) : std::nullopt;
}

std::optional<std::string> CodeTranslator::statements(const std::vector<Stmt>& list) const {
  std::string out;
  for (const Stmt& s : list) {
    const std::optional<std::string> made = statement(s);
    if (!made) return std::nullopt;
    out += *made;
  }
  return out;
}

std::optional<std::string> CodeTranslator::statement(const Stmt& s) const {
  switch (s.kind) {
    case StmtKind::Call: return std::nullopt;
    case StmtKind::If: return if_stmt(s);
    case StmtKind::Change:
    case StmtKind::Assign: return assignment(s);
  }
  BIP_UNREACHABLE("statement");
}

std::optional<std::string> CodeTranslator::if_stmt(const Stmt& s) const {
  const std::optional<std::string> condition = value(s.exprs[0], ValueKind::Bool);
  const std::optional<std::string> then_body = statements(s.then_body), else_body = statements(s.else_body);
  if (!condition || !then_body || !else_body) return std::nullopt;
  std::string out = "if (" + *condition + ") then " + *then_body;
  if (!s.else_body.empty()) out += "else " + *else_body;
  return out + "fi ";
}

// `x = value` and `x op= value`.
std::optional<std::string> CodeTranslator::assignment(const Stmt& s) const {
  BIP_ASSERT(s.exprs.size() == 1 && !s.target.empty(), "an assignment of {} values", s.exprs.size());
  const auto found = variables_.find(joined(s.target));
  if (found == variables_.end() || !found->second.is_writable) return std::nullopt;
  const VariableType& type = found->second.type;
  const std::string target = names_.path(s.target);
  if (s.kind == StmtKind::Change) {
    const std::optional<Value> change = any(s.exprs[0]);
    if (!change || !is_number(change->kind) || !is_number(type.kind)) return std::nullopt;
    // C computes in the larger type and converts back.
    if (type.kind == ValueKind::Int && change->kind != ValueKind::Int) return std::nullopt;
    if (s.op == "%" && type.kind != ValueKind::Int) return std::nullopt;
    const bool is_one =
        s.exprs[0].kind == ExprKind::Int || s.exprs[0].kind == ExprKind::Variable || s.exprs[0].kind == ExprKind::Float;
    return target + " = " + target + " " + s.op + " " + (is_one ? change->text : "(" + change->text + ")") + "; ";
  }
  if (type.kind == ValueKind::Object) {
    const std::optional<Value> copied = any(s.exprs[0]);
    if (!copied || copied->kind != ValueKind::Object || copied->type != type.cpp) return std::nullopt;
    return target + " = " + copied->text + "; ";
  }
  const std::optional<std::string> assigned = value(s.exprs[0], type.kind);
  return assigned ? std::optional(target + " = " + *assigned + "; ") : std::nullopt;
}

}  // namespace bip::migrate
