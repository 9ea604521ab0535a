// What stands for a name in code: the value of a constant, the argument of a function. Part of CodeBuilder
// (code_builder.hpp). Code is in tree form (code.hpp), so each use has rows of its own.
//
// Constants are folded once, so a chain of them in which each is twice the one before costs nothing; arguments are
// counted by the caller.
#include "compiler/model/code_builder.hpp"
#include "compiler/model/evaluate.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::model {

// Not deeper than the parser's limit and kMaxUnfoldedDepth allow.
ExprId CodeBuilder::copy(ExprId from) {
  CodeTable& code = model_.code;
  Expr e = code.exprs[from];
  BIP_ASSERT(!e.a.is_valid() || e.a < from, "operands come before their operator: {} after {}", e.a, from);
  BIP_ASSERT(e.op != Op::Call || e.index < code.functions.size(), "function {} of {}", e.index, code.functions.size());
  if (e.a.is_valid()) e.a = copy(e.a);
  if (e.b.is_valid()) e.b = copy(e.b);
  if (e.op == Op::Call) {
    std::vector<ExprId> args;
    for (std::size_t k = 0; k < code.functions[e.index].params.size(); ++k)
      args.push_back(copy(code.args[static_cast<std::size_t>(e.int_value) + k]));
    e.int_value = static_cast<std::int32_t>(code.args.size());
    code.args.insert(code.args.end(), args.begin(), args.end());
  }
  return make(e);
}

ExprId CodeBuilder::folded(ExprId value) {
  const CodeTable& code = model_.code;
  BIP_ASSERT(code.exprs.contains(value), "row {} of {}", value, code.exprs.size());
  const Evaluated known = evaluate(code, value, {});
  if (known.fault == Fault::Call) return value;
  const Type type = code.exprs[value].type;
  const Loc at = code.exprs[value].loc;
  if (known.fault == Fault::None) {
    const ExprId row = poison(type);
    Expr& e = model_.code.exprs[row];
    e.int_value = known.value.int_value;
    e.float_value = known.value.float_value;
    e.loc = at;
    return row;
  }
  const bool by_zero = known.fault == Fault::DivisionByZero;
  const ExprId low = make({.int_value = by_zero ? 1 : INT32_MIN, .loc = at});
  const ExprId high = make({.int_value = by_zero ? 0 : -1, .loc = at});
  const ExprId division = make({.op = code.exprs[known.at].op, .a = low, .b = high, .loc = code.exprs[known.at].loc});
  if (type == Type::Int) return division;
  if (type == Type::Float) return make({.op = Op::IntToFloat, .type = type, .a = division, .b = {}, .loc = at});
  return make({.op = Op::Eq, .type = Type::Bool, .a = division, .b = make({.loc = at}), .loc = at});
}

}  // namespace bip::model
