// What a piece of code reads and changes: walks over expressions and statements for the checks. Linear, iterative.
#pragma once
#include <vector>

#include "compiler/model/code.hpp"

namespace bip::model {

/// Calls `visit(const Expr&)` on every expression below `root`, arguments of calls included.
template <class Visit>
void visit_exprs(const CodeTable& code, ExprId root, Visit visit) {
  std::vector<ExprId> todo{root};
  while (!todo.empty()) {
    const ExprId id = todo.back();
    todo.pop_back();
    if (!id.is_valid()) continue;
    const Expr& e = code.exprs[id];
    visit(e);
    todo.insert(todo.end(), {e.a, e.b});
    if (e.op != Op::Call) continue;
    for (const ExprId arg : code.args_of(e)) todo.push_back(arg);
  }
}

/// Calls `visit(const Stmt&)` on every statement from `first` on, those of branches included.
template <class Visit>
void visit_stmts(const CodeTable& code, StmtId first, Visit visit) {
  std::vector<StmtId> todo{first};
  while (!todo.empty()) {
    const StmtId id = todo.back();
    todo.pop_back();
    if (!id.is_valid()) continue;
    const Stmt& s = code.stmts[id];
    visit(s);
    todo.insert(todo.end(), {s.next, s.then_body, s.else_body});
  }
}

/// Marks the variables of the kind (LoadSelf or LoadBind) that the expression reads; `marks` has a row for each.
inline void mark_reads(const CodeTable& code, ExprId root, Op load, std::vector<bool>& marks) {
  visit_exprs(code, root, [&](const Expr& e) {
    if (e.op == load) marks[e.index] = true;
  });
}

/// Marks the variables that a call in the expression hands over to C++ by reference.
inline void mark_changes(const CodeTable& code, ExprId root, Op load, std::vector<bool>& marks) {
  visit_exprs(code, root, [&](const Expr& e) {
    if (e.op != Op::Call) return;
    const std::span<const ExprId> args = code.args_of(e);
    for (std::size_t k = 0; k < args.size(); ++k) {
      const Expr& arg = code.exprs[args[k]];
      if (code.functions[e.index].params[k].by_reference && arg.op == load) marks[arg.index] = true;
    }
  });
}

/// Marks the variables of the kind that the statements assign, or hand over to C++.
inline void mark_writes(const CodeTable& code, StmtId first, Op load, std::vector<bool>& marks) {
  const StmtOp store = load == Op::LoadSelf ? StmtOp::StoreSelf : StmtOp::StoreBind;
  visit_stmts(code, first, [&](const Stmt& s) {
    if (s.op == store) marks[s.index] = true;
    mark_changes(code, s.value, load, marks);
  });
}

}  // namespace bip::model
