// Random well-typed expressions and statements. Divisors are kept from zero by `(e & 7) + 1` unless the style asks for
// faults; integer constants near the ends of the range make sums and products wrap.
#include "tools/gen/make.hpp"

namespace bip::gen {

Expr unary(std::string op, Expr a, Ty type) {
  Expr e;
  e.kind = ExprKind::Unary;
  e.type = type;
  e.text = std::move(op);
  e.args.push_back(std::move(a));
  return e;
}
Expr binary(std::string op, Expr a, Expr b, Ty type) {
  Expr e;
  e.kind = ExprKind::Binary;
  e.type = type;
  e.text = std::move(op);
  e.args.push_back(std::move(a));
  e.args.push_back(std::move(b));
  return e;
}
Expr int_literal(int value) {
  Expr e;
  e.text = std::to_string(value);
  return e;
}

Ty CodeMaker::type() {
  if (style_->objects && random_->percent(25)) return random_->percent(60) ? Ty::Pair : Ty::Wide;
  return native_type();
}

Ty CodeMaker::native_type() {
  static const std::vector<Ty> kinds = {Ty::Int, Ty::Int, Ty::Int, Ty::Bool, Ty::Float, Ty::String};
  const Ty type = random_->pick(kinds);
  return style_->narrow && type == Ty::Float ? Ty::Int : type;
}

Expr CodeMaker::literal(Ty type) {
  static const std::vector<std::string> ints = {"2147483647", "1000000007", "65536", "2147483646", "46341"};
  static const std::vector<std::string> floats = {"0.5", "1.",  ".25",        "1e3",  "1.5e-2",
                                                  "3.0", "0.1", "123456.789", "1e300"};
  static const std::vector<std::string> strings = {"\"\"",       "\"a\"",      "\"b\"",      "\"two words\"",
                                                   "\"q\\\"q\"", "\"tab\\t\"", "\"\\u00e9\""};
  Expr e;
  e.type = type;
  switch (type) {
    case Ty::Int: e.text = random_->percent(6) ? random_->pick(ints) : std::to_string(random_->below(10)); break;
    case Ty::Bool: e.text = random_->percent(50) ? "true" : "false"; break;
    case Ty::Float: e.text = random_->pick(floats); break;
    case Ty::String: e.text = random_->pick(strings); break;
    case Ty::Pair: return pair_of(literal(Ty::Int), literal(Ty::Int));
    case Ty::Wide: return call(Ty::Wide, {}, 0);
  }
  return e;
}

Expr CodeMaker::leaf(Ty type, const std::vector<Known>& known) {
  std::vector<const Known*> fitting;
  if (!style_->constants.empty() && random_->percent(12)) {
    const Var& var = random_->pick(style_->constants);
    if (var.type == type) return constant(var);
  }
  for (const Known& k : known) {
    if (k.type == type || (type == Ty::Pair && k.type == Ty::Wide) ||
        (type == Ty::Float && k.type == Ty::Int && random_->percent(30)))
      fitting.push_back(&k);
  }
  if (fitting.empty() || random_->percent(25)) return literal(type);
  return name_of(*random_->pick(fitting));
}

Expr CodeMaker::int_operation(const std::vector<Known>& known, int depth) {
  static const std::vector<std::string> ops = {"+", "+", "-", "*", "&", "|", "^", "/", "%"};
  if (random_->percent(12))
    return unary(random_->percent(50) ? "-" : "~", expression(Ty::Int, known, depth - 1), Ty::Int);
  std::string op = random_->pick(ops);
  Expr a = expression(Ty::Int, known, depth - 1), b = expression(Ty::Int, known, depth - 1);
  bool division = op == "/" || op == "%";
  if (style_->regular && division) {
    op = "-";
    division = false;
  }
  if (division && !(style_->faults && random_->percent(30))) {
    b = binary("+", binary("&", std::move(b), int_literal(7), Ty::Int), int_literal(1), Ty::Int);
  }
  return binary(op, std::move(a), std::move(b), Ty::Int);
}

Expr CodeMaker::bool_operation(const std::vector<Known>& known, int depth) {
  static const std::vector<std::string> relations = {"<", ">", "<=", ">=", "==", "!="};
  static const std::vector<std::string> equalities = {"==", "!="};
  if (random_->percent(12)) return unary("!", expression(Ty::Bool, known, depth - 1), Ty::Bool);
  if (random_->percent(30)) {
    std::string op = random_->percent(50) ? "&&" : "||";
    Expr a = expression(Ty::Bool, known, depth - 1);
    return binary(op, std::move(a), expression(Ty::Bool, known, depth - 1), Ty::Bool);
  }
  if (random_->percent(25)) {
    // Holds about as often as not, whatever the values have grown to.
    int mask = random_->percent(50) ? 1 : 3;
    Expr low_bits = binary("&", expression(Ty::Int, known, depth - 1), int_literal(mask), Ty::Int);
    return binary(random_->pick(equalities), std::move(low_bits), int_literal(random_->between(0, mask)), Ty::Bool);
  }
  Ty operand = type();
  if (operand == Ty::Pair || operand == Ty::Wide) return call(Ty::Bool, known, depth);
  bool ordered = operand == Ty::Int || operand == Ty::Float;
  std::string op = random_->pick(ordered ? relations : equalities);
  Expr a = expression(operand, known, depth - 1), b = expression(operand, known, depth - 1);
  // `x < x` tells little.
  if (a.kind == ExprKind::Name && b.kind == ExprKind::Name && a.scope == b.scope && a.name == b.name)
    b = literal(operand);
  return binary(op, std::move(a), std::move(b), Ty::Bool);
}

Expr CodeMaker::float_operation(const std::vector<Known>& known, int depth) {
  static const std::vector<std::string> ops = {"+", "-", "*", "/"};
  if (random_->percent(15)) {
    Expr a = expression(Ty::Float, known, depth - 1);
    if (a.type == Ty::Float) return unary("-", std::move(a), Ty::Float);
    return a;
  }
  std::string op = random_->pick(ops);
  Expr a = expression(Ty::Float, known, depth - 1), b = expression(Ty::Float, known, depth - 1);
  if (op == "/") {  // a divisor of at least 1
    Expr square = binary("*", b, b, b.type);
    Expr number;
    number.type = Ty::Float;
    number.text = "1.0";
    b = b.type == Ty::Int ? std::move(number) : binary("+", std::move(square), std::move(number), Ty::Float);
  }
  // Two int operands make an int operation, whose value is then converted.
  Ty result = a.type == Ty::Float || b.type == Ty::Float ? Ty::Float : Ty::Int;
  return binary(op, std::move(a), std::move(b), result);
}

Expr CodeMaker::expression(Ty type, const std::vector<Known>& known, int depth) {
  Expr e;
  const bool may_call = style_->calls || style_->ffi;
  const InlineFunction* function =
      style_->functions.empty() || !random_->percent(15) ? nullptr : &random_->pick(style_->functions);
  if (depth > 0 && function != nullptr && function->result == type) {
    e = inline_call(*function, known, depth);
  } else if (depth > 0 && may_call &&
             random_->percent(type == Ty::String || type == Ty::Pair || type == Ty::Wide ? 60 : 15)) {
    e = call(type, known, depth);
  } else if (depth <= 0 || type == Ty::String || type == Ty::Pair || type == Ty::Wide || random_->percent(30)) {
    e = leaf(type, known);
  } else if (type == Ty::Int) {
    e = int_operation(known, depth);
  } else if (type == Ty::Bool) {
    e = bool_operation(known, depth);
  } else {
    e = float_operation(known, depth);
  }
  e.extra_parens = e.kind != ExprKind::Literal && random_->percent(5);
  return e;
}

Expr CodeMaker::guard(const std::vector<Known>& known) {
  if (random_->percent(5)) return literal(Ty::Bool);
  return expression(Ty::Bool, known, random_->between(1, 3));
}

Stmt CodeMaker::assignment(const Known& target, const std::vector<Known>& known, int depth) {
  Stmt stmt;
  stmt.scope = target.scope;
  stmt.name = target.name;
  stmt.value = expression(target.type, known, depth);
  bool to_itself =
      stmt.value.kind == ExprKind::Name && stmt.value.scope == target.scope && stmt.value.name == target.name;
  if (to_itself)
    stmt.value = target.type == Ty::Bool ? unary("!", std::move(stmt.value), Ty::Bool) : literal(target.type);
  return stmt;
}

Body CodeMaker::body(const std::vector<Known>& known, int count, int depth, Changes changes) {
  std::vector<const Known*> targets;
  for (const Known& k : known) {
    if (k.writable) targets.push_back(&k);
  }
  Body result;
  if (targets.empty()) return result;
  for (int i = 0; i < count; ++i) {
    if (style_->ffi && changes == Changes::ByCalls && random_->percent(25)) {
      std::optional<Stmt> stmt = call_statement(known, 1);
      if (stmt) {
        result.push_back(std::move(*stmt));
        continue;
      }
    }
    if (depth > 0 && random_->percent(20)) {
      Stmt stmt;
      stmt.is_if = true;
      stmt.value = guard(known);
      stmt.then_body = body(known, random_->between(1, 2), depth - 1, changes);
      if (random_->percent(50)) stmt.else_body = body(known, random_->between(1, 2), depth - 1, changes);
      result.push_back(std::move(stmt));
    } else {
      result.push_back(assignment(*random_->pick(targets), known, random_->between(0, 3)));
    }
  }
  return result;
}

}  // namespace bip::gen
