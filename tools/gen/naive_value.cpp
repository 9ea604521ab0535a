// A tree walk with the types looked at on the way. int is computed in 64 bits and wrapped, which is not how any executor
// does it.
#include "tools/gen/naive_value.hpp"

#include <cstdlib>

namespace bip::gen {
namespace {

Value of_int(std::int64_t wide) {
  Value v;
  v.i = static_cast<std::int32_t>(static_cast<std::uint32_t>(static_cast<std::uint64_t>(wide)));
  return v;
}
Value of_bool(bool truth) {
  Value v;
  v.type = Ty::Bool;
  v.i = truth ? 1 : 0;
  return v;
}
Value of_float(double f) {
  Value v;
  v.type = Ty::Float;
  v.f = f;
  return v;
}

std::string unquoted(const std::string& text) {
  std::string result;
  for (std::size_t k = 1; k + 1 < text.size(); ++k) {
    if (text[k] != '\\') {
      result += text[k];
      continue;
    }
    ++k;
    if (text[k] == 't') {
      result += '\t';
    } else if (text[k] == 'u') {
      // The only one that the generator writes is below U+0800.
      unsigned long code = std::strtoul(text.substr(k + 1, 4).c_str(), nullptr, 16);
      result += static_cast<char>(0xc0 | (code >> 6));
      result += static_cast<char>(0x80 | (code & 0x3f));
      k += 4;
    } else {
      result += text[k];
    }
  }
  return result;
}

Value literal(const Expr& expr) {
  switch (expr.type) {
    case Ty::Int: return of_int(std::strtoll(expr.text.c_str(), nullptr, 10));
    case Ty::Bool: return of_bool(expr.text == "true");
    case Ty::Float: return of_float(std::strtod(expr.text.c_str(), nullptr));
    case Ty::String: break;
  }
  Value v;
  v.type = Ty::String;
  v.s = unquoted(expr.text);
  return v;
}

template <class T>
bool related(const std::string& op, const T& a, const T& b) {
  if (op == "==") return a == b;
  if (op == "!=") return a != b;
  if (op == "<") return a < b;
  if (op == ">") return a > b;
  if (op == "<=") return a <= b;
  return a >= b;
}

bool is_relation(const std::string& op) {
  return op == "==" || op == "!=" || op == "<" || op == ">" || op == "<=" || op == ">=";
}

Value int_operation(const std::string& op, std::int64_t a, std::int64_t b, bool& fault) {
  if (op == "+") return of_int(a + b);
  if (op == "-") return of_int(a - b);
  if (op == "*") return of_int(a * b);
  if (op == "&") return of_int(a & b);
  if (op == "|") return of_int(a | b);
  if (op == "^") return of_int(a ^ b);
  if (op == "max") return of_int(a > b ? a : b);
  if (op == "min") return of_int(a < b ? a : b);
  if (b == 0 || (a == INT32_MIN && b == -1)) {
    fault = true;
    return {};
  }
  return of_int(op == "/" ? a / b : a % b);
}

Value float_operation(const std::string& op, double a, double b) {
  if (op == "+") return of_float(a + b);
  if (op == "-") return of_float(a - b);
  if (op == "*") return of_float(a * b);
  return of_float(a / b);
}

Value binary_value(const Expr& expr, const Lookup& lookup, bool& fault) {
  const std::string& op = expr.text;
  Value a = evaluate(expr.args[0], lookup, fault);
  if (fault) return a;
  if (op == "&&" && a.i == 0) return a;
  if (op == "||" && a.i == 1) return a;
  Value b = evaluate(expr.args[1], lookup, fault);
  if (fault || op == "&&" || op == "||") return b;
  if (a.type == Ty::String) return of_bool(related(op, a.s, b.s));
  if (a.type == Ty::Float || b.type == Ty::Float) {
    double x = converted(a, Ty::Float).f, y = converted(b, Ty::Float).f;
    return is_relation(op) ? of_bool(related(op, x, y)) : float_operation(op, x, y);
  }
  if (is_relation(op)) return of_bool(related(op, a.i, b.i));
  return int_operation(op, a.i, b.i, fault);
}

}  // namespace

Value zero_of(Ty type) {
  Value v;
  v.type = type;
  return v;
}

Value converted(Value value, Ty type) {
  if (type == Ty::Float && value.type == Ty::Int) return of_float(value.i);
  return value;
}

Value evaluate(const Expr& expr, const Lookup& lookup, bool& fault) {
  switch (expr.kind) {
    case ExprKind::Literal: return literal(expr);
    case ExprKind::Name: return lookup(expr.scope, expr.name);
    case ExprKind::Binary: return binary_value(expr, lookup, fault);
    case ExprKind::Unary: break;
  }
  Value a = evaluate(expr.args[0], lookup, fault);
  if (expr.text == "!") return of_bool(a.i == 0);
  if (expr.text == "~") return of_int(~static_cast<std::int64_t>(a.i));
  return a.type == Ty::Float ? of_float(-a.f) : of_int(-static_cast<std::int64_t>(a.i));
}

void execute(const Body& body, const Lookup& lookup, bool& fault) {
  for (const Stmt& stmt : body) {
    Value value = evaluate(stmt.value, lookup, fault);
    if (fault) return;
    if (stmt.is_if) {
      execute(value.i != 0 ? stmt.then_body : stmt.else_body, lookup, fault);
      if (fault) return;
    } else {
      Value& target = lookup(stmt.scope, stmt.name);
      target = converted(value, target.type);
    }
  }
}

}  // namespace bip::gen
