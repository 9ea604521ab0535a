// See code_facts.hpp. A division by a constant other than 0 and -1 cannot fault; any call of C++ can.
#include "compiler/lower/code_facts.hpp"

#include <algorithm>

#include "compiler/model/operators.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::lower {

CodeFacts code_facts(const CodeTable& code, ExprId expr, StmtId body) {
  CodeFacts facts;
  std::vector<ExprId> exprs{expr};
  std::vector<StmtId> stmts{body};
  while (!stmts.empty()) {
    const StmtId id = stmts.back();
    stmts.pop_back();
    if (!id.is_valid()) continue;
    const Stmt& s = code.stmts[id];
    switch (s.op) {
      case StmtOp::StoreBind:
        facts.writes_binds = true;
        facts.binds.push_back(s.index);
        break;
      case StmtOp::StoreSelf:
      case StmtOp::If:
      case StmtOp::Call: break;
    }
    exprs.push_back(s.value);
    stmts.insert(stmts.end(), {s.next, s.then_body, s.else_body});
  }
  while (!exprs.empty()) {
    const ExprId id = exprs.back();
    exprs.pop_back();
    if (!id.is_valid()) continue;
    const Expr& e = code.exprs[id];
    if (e.op == Op::LoadBind) facts.binds.push_back(e.index);
    if (e.op == Op::Call) {
      facts.calls = true;
      const std::span<const ExprId> args = code.args_of(e);
      exprs.insert(exprs.end(), args.begin(), args.end());
      continue;
    }
    if (is_division(e.op) && e.type == Type::Int) {
      const Expr& by = code.exprs[e.b];
      if (by.op != Op::ConstInt || by.int_value == 0 || by.int_value == -1) facts.divisors.push_back(e.b);
    }
    exprs.insert(exprs.end(), {e.a, e.b});
  }
  facts.may_fault = facts.calls || !facts.divisors.empty();
  std::sort(facts.binds.begin(), facts.binds.end());
  facts.binds.erase(std::unique(facts.binds.begin(), facts.binds.end()), facts.binds.end());
  BIP_ASSERT(facts.writes_binds <= !facts.binds.empty(), "code writes bound variables, and names none");
  return facts;
}

}  // namespace bip::lower
