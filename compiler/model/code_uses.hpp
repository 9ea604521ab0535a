// Walks over expressions and statements, and what a piece of code reads and changes. Linear, iterative.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "compiler/model/code.hpp"
#include "compiler/model/statements.hpp"

namespace bip::model {

/// Calls `see(const Expr&)` for every expression from `root` down, in preorder: a before b before the arguments of a
/// call.
template <class See>
void for_each_expr(const CodeTable& code, ExprId root, const See& see) {
  std::vector<ExprId> todo{root};
  while (!todo.empty()) {
    const ExprId id = todo.back();
    todo.pop_back();
    if (!id.is_valid()) continue;
    const Expr& e = code.exprs[id];
    see(e);
    if (e.op == Op::Call) {
      const std::span<const ExprId> args = code.args_of(e);
      todo.insert(todo.end(), args.rbegin(), args.rend());
    }
    todo.insert(todo.end(), {e.b, e.a});
  }
}

/// Calls `see(const Stmt&)` for every statement from `first` on, in the order of the text: the branches of an `if` come
/// before what follows it.
template <class See>
void for_each_stmt(const CodeTable& code, StmtId first, const See& see) {
  std::vector<StmtId> todo{first};
  while (!todo.empty()) {
    const StmtId id = todo.back();
    todo.pop_back();
    if (!id.is_valid()) continue;
    const Stmt& s = code.stmts[id];
    see(s);
    todo.insert(todo.end(), {s.next, s.else_body, s.then_body});
  }
}

/// Returns the variable of the kind (LoadSelf or LoadBind) that the statement itself assigns, or nothing: branches, and
/// what a call changes by reference, do not count.
[[nodiscard]] inline std::optional<std::uint32_t> assigned_variable(const Stmt& s, Op load) {
  switch (shape_of(s)) {
    case StmtShape::StoresSelf: return load == Op::LoadSelf ? std::optional(s.index) : std::nullopt;
    case StmtShape::StoresBind: return load == Op::LoadBind ? std::optional(s.index) : std::nullopt;
    case StmtShape::Chooses:
    case StmtShape::Evaluates: break;
  }
  return std::nullopt;
}

/// Does the statement do nothing but choose between its branches?
[[nodiscard]] inline bool is_choice(const Stmt& s) { return shape_of(s) == StmtShape::Chooses; }

/// Does the statement do nothing but evaluate its value, of which nothing is kept?
[[nodiscard]] inline bool is_evaluation(const Stmt& s) {
  switch (s.op) {
    case StmtOp::Call: return true;
    case StmtOp::StoreSelf:
    case StmtOp::StoreBind:
    case StmtOp::If: break;
  }
  return false;
}

/// Calls `see(std::uint32_t variable)` for every assignment to a variable of the kind, in the order of the text.
template <class See>
void for_each_assigned(const CodeTable& code, StmtId first, Op load, const See& see) {
  for_each_stmt(code, first, [&](const Stmt& s) {
    if (const std::optional<std::uint32_t> variable = assigned_variable(s, load)) see(*variable);
  });
}

/// Marks the variables of the kind (LoadSelf or LoadBind) that the expression reads; `marks` has a row for each.
inline void mark_reads(const CodeTable& code, ExprId root, Op load, std::vector<bool>& marks) {
  for_each_expr(code, root, [&](const Expr& e) {
    if (e.op == load) marks[e.index] = true;
  });
}

/// Marks the variables that a call in the expression hands over to C++ by reference.
inline void mark_changes(const CodeTable& code, ExprId root, Op load, std::vector<bool>& marks) {
  for_each_expr(code, root, [&](const Expr& e) {
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
  for_each_assigned(code, first, load, [&](std::uint32_t variable) { marks[variable] = true; });
  for_each_stmt(code, first, [&](const Stmt& s) { mark_changes(code, s.value, load, marks); });
}

}  // namespace bip::model
