// Expressions and statements of .bsys. Types of operators and loads follow from their operands and from the scope.
//
// Recursive: depth is limited by kMaxParentheses. Only ids and shapes are checked here; `validate` checks types.
#include <fmt/format.h>

#include "compiler/system/parse_bsys_reader.hpp"

namespace bip::system::text {
namespace {

Op constant_of(Type type) {
  switch (type) {
    case Type::Int: return Op::ConstInt;
    case Type::Bool: return Op::ConstBool;
    case Type::Float: return Op::ConstFloat;
    case Type::String: break;
  }
  return Op::ConstString;
}

/// The result's type if the operands are right.
Type result_of(Op op, Type operand) {
  if (op == Op::IntToFloat) return Type::Float;
  if (op == Op::Not || op >= Op::And) return Type::Bool;
  return operand;
}

}  // namespace

std::uint32_t BsysReader::variable(List& list, const std::vector<ScopeVariable>& variables) {
  return ref(list, variables.size(), "variable",
             [&](std::uint32_t k) -> const std::string& { return variables[k].name; });
}

ExprId BsysReader::expr(List& list, const CodeScope& scope) {
  const std::uint32_t node = next(list, "an expression");
  return node == kNoNode ? ExprId() : expr(node, scope);
}

ExprId BsysReader::expr(std::uint32_t node, const CodeScope& scope) {
  if (failed()) return {};
  if (tree_.nodes[node].kind != Node::Kind::List) {
    const Value value = literal(node);
    Expr constant;
    constant.op = constant_of(value.type);
    constant.type = value.type;
    constant.int_value = value.int_value;
    constant.float_value = value.float_value;
    return s_.code.exprs.push(constant);
  }
  std::string_view head;
  List list = open(node, head);
  Expr e;
  if (head == "self" || head == "bind") {
    e.op = head == "self" ? Op::LoadSelf : Op::LoadBind;
    const std::vector<ScopeVariable>& variables = head == "self" ? scope.self : scope.bind;
    e.index = variable(list, variables);
    if (!failed()) e.type = variables[e.index].type;
  } else if (head == "call") {
    e.op = Op::Call;
    e.index = ref(list, s_.code.functions.size(), "function",
                  [&](std::uint32_t k) -> const std::string& { return s_.code.functions[k].name; });
    std::vector<ExprId> args;
    while (more(list)) args.push_back(expr(list, scope));
    if (!failed() && args.size() != s_.code.functions[e.index].params.size())
      fail(node, "a call has not one argument a parameter");
    if (!failed()) e.type = s_.code.functions[e.index].result;
    e.int_value = static_cast<std::int32_t>(s_.code.args.size());
    s_.code.args.insert(s_.code.args.end(), args.begin(), args.end());
  } else if (const std::optional<Op> op = op_of(head)) {
    e.op = *op;
    e.a = expr(list, scope);
    if (operand_count(e.op) == 2) e.b = expr(list, scope);
    if (!failed()) e.type = result_of(e.op, s_.code.exprs[e.a].type);
  } else {
    fail(node, "expected an expression; no operator has this name");
  }
  close(list);
  e.loc = list.loc;
  return failed() ? ExprId() : s_.code.exprs.push(e);
}

StmtId BsysReader::stmt(std::uint32_t node, const CodeScope& scope) {
  std::string_view head;
  List list = open(node, head);
  Stmt s;
  if (head == "set" || head == "set-bind") {
    s.op = head == "set" ? StmtOp::StoreSelf : StmtOp::StoreBind;
    const std::vector<ScopeVariable>& variables = head == "set" ? scope.self : scope.bind;
    s.index = variable(list, variables);
    if (!failed()) s.type = variables[s.index].type;
    s.value = expr(list, scope);
  } else if (head == "do") {
    s.op = StmtOp::Call;
    s.value = expr(list, scope);
    if (!failed()) s.type = s_.code.exprs[s.value].type;
  } else if (head == "if") {
    s.op = StmtOp::If;
    s.value = expr(list, scope);
    List then_list = need(list, "then");
    s.then_body = body(then_list, scope);
    if (std::optional<List> else_list = sub(list, "else")) s.else_body = body(*else_list, scope);
  } else {
    fail(node, "expected a statement: set, set-bind, do or if");
  }
  close(list);
  s.loc = list.loc;
  return failed() ? StmtId() : s_.code.stmts.push(s);
}

StmtId BsysReader::body(List& list, const CodeScope& scope) {
  StmtId first, last;
  while (more(list)) {
    const StmtId id = stmt(next(list, "a statement"), scope);
    if (failed()) return {};
    (first.is_valid() ? s_.code.stmts[last].next : first) = id;
    last = id;
  }
  // A body's list has no place of its own.
  if (!failed() && list.loc.line != 0) fail(list.node, "no place belongs here");
  return first;
}

}  // namespace bip::system::text
