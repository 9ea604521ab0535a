// Prints expressions of the code IR as C++.
//
// int arithmetic uses wrap_add … and divide/modulo; other operators are C++'s. C++ does not specify the order in which
// the operands of a binary operator are evaluated. The order is observable only if both can fault or one calls C++;
// then the operands are bound to names left to right first.
#include "compiler/emit_cpp/functions.hpp"
#include "compiler/model/print_expr.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::emit_cpp {

namespace {

using Text = ExprText;

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
    case Op::ConstInt:
      return {e.int_value < 0 ? parens(int_literal(e.int_value)) : int_literal(e.int_value)};
      BIP_LOAD_OPS(BIP_OP_CASE)
      BIP_CALL_OPS(BIP_OP_CASE)
      BIP_UNARY_OPS(BIP_OP_CASE)
      BIP_BINARY_OPS(BIP_OP_CASE)
      break;
  }
  BIP_UNREACHABLE("not a constant");
}

Text unary(ExprContext& c, const Expr& e) {
  Text a = text_of(c, e.a);
  if (e.op == Op::IntToFloat) return {"static_cast<double>(" + a.text + ")"};
  const char* function = info_of(e.op).function;
  if (function != nullptr && e.type == Type::Int) return {function + parens(a.text)};
  return print_unary(Dialect::Cpp, e.op, std::move(a));
}

Text combine(const ExprContext& c, ExprId id, const Expr& e, const Text& a, const Text& b) {
  const char* function = info_of(e.op).function;
  if (function != nullptr && e.type == Type::Int) {
    std::string call = std::string(function) + "(" + a.text + ", " + b.text;
    const std::uint32_t site = c.lowered.site_of_expr[id.value];
    if (site != rt::kNone) call += ", " + std::to_string(site);
    return {call + ")"};
  }
  return print_binary(Dialect::Cpp, e.op, a, b);
}

Text binary(ExprContext& c, ExprId id, const Expr& e) {
  const bool short_circuit = family_of(e.op) == OpFamily::Logic;
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
  BIP_ASSERT(args.size() == function.params.size(), "{} arguments for `{}`", args.size(), function.name);
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
    case Op::BitNot:
      return unary(c, e);
      BIP_BINARY_OPS(BIP_OP_CASE)
      return binary(c, id, e);
  }
  BIP_UNREACHABLE("operator");
}

}  // namespace

std::string expr_text(ExprContext& context, ExprId id) { return text_of(context, id).text; }

bool FaultInfo::calls(ExprId id) const {
  const CodeTable& code = lowered_.system->code;
  if (!id.is_valid() || code.functions.empty()) return false;
  const Expr& e = code.exprs[id];
  return e.op == Op::Call || (operand_count(e.op) >= 1 && calls(e.a)) || (operand_count(e.op) == 2 && calls(e.b));
}

bool FaultInfo::can_fault(ExprId id) {
  if (!id.is_valid()) return false;
  if (known_[id.value] == 0) {
    const Expr& e = lowered_.system->code.exprs[id];
    const bool has_a = operand_count(e.op) >= 1;
    const bool has_b = operand_count(e.op) == 2;
    const bool yes =
        lowered_.site_of_expr[id.value] != rt::kNone || (has_a && can_fault(e.a)) || (has_b && can_fault(e.b));
    known_[id.value] = yes ? 2 : 1;
  }
  return known_[id.value] == 2;
}

}  // namespace bip::emit_cpp
