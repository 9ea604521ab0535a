// One walk over guards and actions for all abstract domains (constants, intervals, affine forms, words of a circuit):
// P. Cousot, R. Cousot: Abstract Interpretation (1977). The walk fixes the order of evaluation and which rows are
// operands; a domain says what values are, what operators do to them (transfer functions) and how branches join.
//
// A domain derives from AbstractInterpreter<Domain, Value, Point, State>: expressions have a Value at a Point,
// statements change a State, which is a Point or a set of them. It has
//   Value constant(e)                 load(e, point)      call(e, point)
//   Value unary(e, a, point)          binary(e, a, b, point): the operands' values are given
//   Value logic(e, point)             && and ||: the domain evaluates the operands, as the second one is conditional
//   void forget(load, point)          a call of C++ may have changed this variable
//   void store(stmt, state)           branch(stmt, state)      run_call(stmt, state)
//   bool goes_on(state)               false: the rest of a body is skipped
// An operator that a domain forgets does not compile: its switches over Op have no `default:`.
// Recursion follows the code's trees, whose depth the parser and the .bsys reader bound.
#pragma once
#include "compiler/model/operators.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip {

template <class Domain, class Value, class Point, class State = Point>
class AbstractInterpreter {
 public:
  explicit AbstractInterpreter(const CodeTable& code) : code_(code) {}

  [[nodiscard]] Value evaluate(ExprId id, Point& point) {
    const Expr& e = code_.exprs[id];
    switch (family_of(e.op)) {
      case OpFamily::Constant: return domain().constant(e);
      case OpFamily::Load: return domain().load(e, point);
      case OpFamily::Call: return domain().call(e, point);
      case OpFamily::Conversion:
      case OpFamily::Sign: return domain().unary(e, domain().evaluate(e.a, point), point);
      case OpFamily::Logic: return domain().logic(e, point);
      case OpFamily::Arithmetic:
      case OpFamily::Division:
      case OpFamily::Bitwise:
      case OpFamily::Equality:
      case OpFamily::Order: {
        Value a = domain().evaluate(e.a, point);
        Value b = domain().evaluate(e.b, point);
        return domain().binary(e, a, b, point);
      }
    }
    BIP_UNREACHABLE("operator family");
  }

  void execute(StmtId body, State& state) {
    for (StmtId id = body; id.is_valid() && domain().goes_on(state); id = code_.stmts[id].next) {
      const Stmt& s = code_.stmts[id];
      switch (s.op) {
        case StmtOp::StoreSelf:
        case StmtOp::StoreBind: domain().store(s, state); break;
        case StmtOp::If: domain().branch(s, state); break;
        case StmtOp::Call: domain().run_call(s, state); break;
      }
    }
  }

 protected:
  /// Evaluates the arguments of a call that are given by value, and forgets the others, from left to right.
  void pass_arguments(const Expr& call, Point& point) {
    const std::span<const ExprId> args = code_.args_of(call);
    for (std::size_t k = 0; k < args.size(); ++k) {
      const Expr& arg = code_.exprs[args[k]];
      if (!code_.functions[call.index].params[k].by_reference) (void)domain().evaluate(args[k], point);
      else if (is_load(arg.op)) domain().forget(arg, point);
    }
  }

  const CodeTable& code_;

 private:
  [[nodiscard]] Domain& domain() { return static_cast<Domain&>(*this); }
};

}  // namespace bip
