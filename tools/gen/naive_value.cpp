// A tree walk that checks types while it evaluates. int is computed in 64 bits and then wrapped, unlike in any
// executor.
#include "tools/gen/naive_value.hpp"

#include <cstdlib>

#include "tools/gen/ffi_prototypes.hpp"

namespace bip::gen {

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

namespace {

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
    case Ty::String:
    case Ty::Pair:
    case Ty::Wide: break;
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

/// Arguments from left to right; one by reference is the variable itself.
Value call_value(const Expr& expr, const Lookup& lookup, Place& at) {
  const FfiPrototype& function = ffi_functions()[static_cast<std::size_t>(expr.row)];
  std::vector<Value> values(expr.args.size());
  std::vector<Value*> args;
  for (std::size_t k = 0; k < expr.args.size(); ++k) {
    if (function.params[k].by_reference) {
      args.push_back(&lookup(expr.args[k].scope, expr.args[k].name));
      continue;
    }
    values[k] = evaluate(expr.args[k], lookup, at);
    if (at.fault) return {};
    if (function.params[k].type == Ty::Float) values[k] = converted(values[k], Ty::Float);
    args.push_back(&values[k]);
  }
  Value result;
  at.fault = !function.apply(args, at.is_const, result);
  return result;
}

/// The body; a parameter is its argument wherever it stands.
Value inline_value(const Expr& expr, const Lookup& lookup, Place& at) {
  Value given;
  const Lookup inside = [&](const std::string& scope, const std::string& name) -> Value& {
    if (scope != "$") return lookup(scope, name);
    const Expr& arg = expr.args[static_cast<std::size_t>(name[1] - '0')];
    return given = converted(evaluate(arg, lookup, at), name[0] == 'f' ? Ty::Float : arg.type);
  };
  return converted(evaluate(expr.args.back(), inside, at), expr.type);
}

Value binary_value(const Expr& expr, const Lookup& lookup, Place& at) {
  const std::string& op = expr.text;
  Value a = evaluate(expr.args[0], lookup, at);
  if (at.fault) return a;
  if (op == "&&" && a.i == 0) return a;
  if (op == "||" && a.i == 1) return a;
  Value b = evaluate(expr.args[1], lookup, at);
  if (at.fault || op == "&&" || op == "||") return b;
  if (a.type == Ty::String) return of_bool(related(op, a.s, b.s));
  if (a.type == Ty::Float || b.type == Ty::Float) {
    double x = converted(a, Ty::Float).f, y = converted(b, Ty::Float).f;
    return is_relation(op) ? of_bool(related(op, x, y)) : float_operation(op, x, y);
  }
  if (is_relation(op)) return of_bool(related(op, a.i, b.i));
  return int_operation(op, a.i, b.i, at.fault);
}

}  // namespace

Value zero_of(Ty type) {
  Value v;
  v.type = type;
  return v;
}

Value converted(Value value, Ty type) {
  if (type == Ty::Float && value.type == Ty::Int) return of_float(value.i);
  if (type == Ty::Pair && value.type == Ty::Wide) {
    value.type = Ty::Pair;
    value.w.c = 0;
  }
  return value;
}

Value evaluate(const Expr& expr, const Lookup& lookup, Place& at) {
  switch (expr.kind) {
    case ExprKind::Literal: return literal(expr);
    case ExprKind::Name: return lookup(expr.scope, expr.name);
    case ExprKind::Constant: return converted(evaluate(expr.args[0], lookup, at), expr.type);
    case ExprKind::Call: return call_value(expr, lookup, at);
    case ExprKind::Draw: return draw_value(expr, lookup, at);
    case ExprKind::Inline: return inline_value(expr, lookup, at);
    case ExprKind::Binary: return binary_value(expr, lookup, at);
    case ExprKind::Unary: break;
  }
  Value a = evaluate(expr.args[0], lookup, at);
  if (expr.text == "!") return of_bool(a.i == 0);
  if (expr.text == "~") return of_int(~static_cast<std::int64_t>(a.i));
  return a.type == Ty::Float ? of_float(-a.f) : of_int(-static_cast<std::int64_t>(a.i));
}

void execute(const Body& body, const Lookup& lookup, Place& at) {
  for (const Stmt& stmt : body) {
    Value value = evaluate(stmt.value, lookup, at);
    if (at.fault) return;
    if (stmt.is_call) continue;
    if (stmt.is_if) {
      execute(value.i != 0 ? stmt.then_body : stmt.else_body, lookup, at);
      if (at.fault) return;
    } else {
      Value& target = lookup(stmt.scope, stmt.name);
      target = converted(value, target.type);
    }
  }
}

}  // namespace bip::gen
