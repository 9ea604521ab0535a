// Prints expressions of the code IR as C++.
//
// int arithmetic uses wrap_add … and divide/modulo; other operators are C++'s. C++ does not specify the order in which
// the operands of a binary operator are evaluated. The order is observable only if both can fault or one calls C++;
// then the operands are bound to names left to right first.
#include "compiler/emit_cpp/functions.hpp"

namespace bip::emit_cpp {

namespace {

// C++'s levels, as far as they occur.
enum Level : int { kOr = 1, kAnd, kBitOr, kBitXor, kBitAnd, kEquality, kRelation, kSum, kProduct, kUnary, kPrimary };

struct Text {
  std::string text;
  int level = kPrimary;
};

const char* operator_of(Op op) {
  switch (op) {
    case Op::Add: return " + ";
    case Op::Sub: return " - ";
    case Op::Mul: return " * ";
    case Op::Div: return " / ";
    case Op::BitAnd: return " & ";
    case Op::BitOr: return " | ";
    case Op::BitXor: return " ^ ";
    case Op::And: return " && ";
    case Op::Or: return " || ";
    case Op::Eq: return " == ";
    case Op::Ne: return " != ";
    case Op::Lt: return " < ";
    case Op::Gt: return " > ";
    case Op::Le: return " <= ";
    case Op::Ge: return " >= ";
    default: return " ? ";
  }
}

int level_of(Op op) {
  switch (op) {
    case Op::Or: return kOr;
    case Op::And: return kAnd;
    case Op::BitOr: return kBitOr;
    case Op::BitXor: return kBitXor;
    case Op::BitAnd: return kBitAnd;
    case Op::Eq:
    case Op::Ne: return kEquality;
    case Op::Add:
    case Op::Sub: return kSum;
    case Op::Mul:
    case Op::Div: return kProduct;
    default: return kRelation;
  }
}

const char* function_of(Op op) {
  switch (op) {
    case Op::Add: return "wrap_add";
    case Op::Sub: return "wrap_sub";
    case Op::Mul: return "wrap_mul";
    case Op::Div: return "divide";
    case Op::Mod: return "modulo";
    default: return nullptr;
  }
}

std::string parens(const std::string& text) { return "(" + text + ")"; }

// An operand: bare if it binds tighter and mixing the two operators surprises nobody (nor -Wparentheses).
std::string operand(const Text& t, int level, bool is_left) {
  const bool chain = t.level == level && is_left && level != kEquality && level != kRelation;
  const bool tighter = t.level > level && t.level >= (level <= kAnd ? kEquality : kSum);
  return chain || tighter ? t.text : parens(t.text);
}

Text text_of(ExprContext& c, ExprId id);

Text constant(const ExprContext& c, const Expr& e) {
  switch (e.op) {
    case Op::ConstBool: return {e.int_value != 0 ? "true" : "false"};
    case Op::ConstString: {
      const std::string& text = c.lowered.system->code.strings[static_cast<std::size_t>(e.int_value)];
      return {std::to_string(e.int_value) + " /* " + comment_text(text) + " */"};
    }
    case Op::ConstFloat: {
      const std::string text = float_literal(e.float_value);
      return {text[0] == '-' ? parens(text) : text};
    }
    default: return {e.int_value < 0 ? parens(int_literal(e.int_value)) : int_literal(e.int_value)};
  }
}

Text unary(ExprContext& c, const Expr& e) {
  const Text a = text_of(c, e.a);
  if (e.op == Op::IntToFloat) return {"static_cast<double>(" + a.text + ")"};
  if (e.op == Op::Neg && e.type == Type::Int) return {"wrap_neg(" + a.text + ")"};
  const char* sign = e.op == Op::Neg ? "-" : e.op == Op::Not ? "!" : "~";
  // Parenthesised as a whole: `!x == y` and `- -x` read badly.
  const std::string inner = a.level == kPrimary ? a.text : parens(a.text);
  return {sign + inner, kUnary};
}

Text combine(const ExprContext& c, ExprId id, const Expr& e, const Text& a, const Text& b) {
  const char* function = function_of(e.op);
  if (function != nullptr && e.type == Type::Int) {
    std::string call = std::string(function) + "(" + a.text + ", " + b.text;
    const std::uint32_t site = c.lowered.site_of_expr[id.value];
    if (site != rt::kNone) call += ", " + std::to_string(site);
    return {call + ")"};
  }
  const int level = level_of(e.op);
  const bool not_on_left = a.level == kUnary && a.text[0] == '!' && (level == kEquality || level == kRelation);
  const std::string left = not_on_left ? parens(a.text) : operand(a, level, true);
  return {left + operator_of(e.op) + operand(b, level, false), level};
}

Text binary(ExprContext& c, ExprId id, const Expr& e) {
  const bool short_circuit = e.op == Op::And || e.op == Op::Or;
  const bool both_fault = c.faults.can_fault(e.a) && c.faults.can_fault(e.b);
  if (short_circuit || !(both_fault || c.faults.calls(e.a) || c.faults.calls(e.b))) {
    const Text a = text_of(c, e.a);
    const Text b = text_of(c, e.b);
    return combine(c, id, e, a, b);
  }
  const std::string type = c.ffi.type(c.lowered.system->code.exprs[e.a].type);
  const std::string left = c.names.make("left");
  const std::string right = c.names.make("right");
  std::string text = std::string("[&] { const ") + type + " " + left + " = " + text_of(c, e.a).text + "; ";
  text += std::string("const ") + type + " " + right + " = " + text_of(c, e.b).text + "; ";
  return {text + "return " + combine(c, id, e, {left}, {right}).text + "; }()"};
}

// C++ leaves the order of arguments open: if it can be seen, those by value are bound first, from left to right.
Text call(ExprContext& c, ExprId id, const Expr& e) {
  const CodeTable& code = c.lowered.system->code;
  const Function& function = code.functions[e.index];
  const std::span<const ExprId> args = code.args_of(e);
  std::size_t faulty = 0;
  bool bind = false;
  for (const ExprId arg : args) {
    faulty += c.faults.can_fault(arg) ? 1 : 0;
    bind = bind || (args.size() > 1 && c.faults.calls(arg));
  }
  bind = bind || faulty > 1;
  std::string before, text = c.ffi.function(e.index) + "(";
  for (std::size_t k = 0; k < args.size(); ++k) {
    const Type type = function.params[k].type;
    std::string arg = text_of(c, args[k]).text;
    if (bind && !function.params[k].by_reference) {
      const std::string name = c.names.make("arg");
      before += "const " + c.ffi.type(type) + (is_ffi(type) ? "& " : " ") + name + " = " + arg + "; ";
      arg = name;
    }
    if (function.params[k].by_reference && !is_ffi(type)) arg += ".ref()";
    text += arg + ", ";
  }
  text += std::to_string(c.lowered.site_of_expr[id.value]) + ")";
  return {bind ? "[&] { " + before + "return " + text + "; }()" : text};
}

Text text_of(ExprContext& c, ExprId id) {
  const Expr& e = c.lowered.system->code.exprs[id];
  switch (e.op) {
    case Op::ConstInt:
    case Op::ConstBool:
    case Op::ConstFloat:
    case Op::ConstString: return constant(c, e);
    case Op::Call: return call(c, id, e);
    case Op::LoadSelf: return {c.self_locals[e.index].name};
    case Op::LoadBind: return {c.bind_locals[e.index].name};
    case Op::IntToFloat:
    case Op::Neg:
    case Op::Not:
    case Op::BitNot: return unary(c, e);
    default: return binary(c, id, e);
  }
}

}  // namespace

std::string expr_text(ExprContext& context, ExprId id) { return text_of(context, id).text; }

bool FaultInfo::calls(ExprId id) const {
  const CodeTable& code = lowered_.system->code;
  if (!id.is_valid() || code.functions.empty()) return false;
  const Expr& e = code.exprs[id];
  return e.op == Op::Call || (e.op >= Op::IntToFloat && calls(e.a)) || (e.op >= Op::Add && calls(e.b));
}

bool FaultInfo::can_fault(ExprId id) {
  if (!id.is_valid()) return false;
  if (known_[id.value] == 0) {
    const Expr& e = lowered_.system->code.exprs[id];
    const bool has_a = e.op >= Op::IntToFloat;
    const bool has_b = e.op >= Op::Add;
    const bool yes =
        lowered_.site_of_expr[id.value] != rt::kNone || (has_a && can_fault(e.a)) || (has_b && can_fault(e.b));
    known_[id.value] = yes ? 2 : 1;
  }
  return known_[id.value] == 2;
}

}  // namespace bip::emit_cpp
