// See range_code.hpp. Recursion follows the nesting of code, which the parser limits.
#include "compiler/lower/range_code.hpp"

#include "compiler/lower/code_facts.hpp"
#include "compiler/model/statements.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::lower {

namespace {

using rt::RangeOp;
using rt::RangeOpKind;

rt::CellType type_of(Type type) { return static_cast<rt::CellType>(type); }

class RangeCodeWriter {
 public:
  RangeCodeWriter(const CodeTable& code, std::vector<RangeOp>& out) : code_(code), out_(out) {}

  void value(ExprId id) {
    const Expr& e = code_.exprs[id];
    switch (e.op) {
      case Op::ConstInt:
      case Op::ConstBool: return add({RangeOpKind::Constant, type_of(e.type), 0, 0, static_cast<double>(e.int_value)});
      case Op::ConstFloat: return add({RangeOpKind::Constant, type_of(e.type), 0, 0, e.float_value});
      case Op::LoadSelf: return load(RangeOpKind::Own, e);
      case Op::LoadBind: return load(RangeOpKind::Bound, e);
      case Op::IntToFloat: return value(e.a);
      case Op::Neg: return unary(RangeOpKind::Neg, e);
      case Op::Not: return unary(RangeOpKind::Not, e);
      case Op::Add: return binary(RangeOpKind::Add, e, e.a, e.b);
      case Op::Sub: return binary(RangeOpKind::Sub, e, e.a, e.b);
      case Op::Mul: return binary(RangeOpKind::Mul, e, e.a, e.b);
      case Op::And: return binary(RangeOpKind::And, e, e.a, e.b);
      case Op::Or: return binary(RangeOpKind::Or, e, e.a, e.b);
      case Op::Eq: return binary(RangeOpKind::Eq, e, e.a, e.b);
      case Op::Ne: return binary(RangeOpKind::Ne, e, e.a, e.b);
      case Op::Lt: return binary(RangeOpKind::Lt, e, e.a, e.b);
      case Op::Le: return binary(RangeOpKind::Le, e, e.a, e.b);
      case Op::Gt: return binary(RangeOpKind::Lt, e, e.b, e.a);
      case Op::Ge: return binary(RangeOpKind::Le, e, e.b, e.a);
      case Op::ConstString:
      case Op::Call:
      case Op::BitNot:
        BIP_DIVISION_OPS(BIP_OP_CASE)
        BIP_BITWISE_OPS(BIP_OP_CASE)
        return any(e.type);
    }
  }

  void body(StmtId first) {
    for (StmtId id = first; id.is_valid(); id = code_.stmts[id].next) {
      const Stmt& s = code_.stmts[id];
      value(s.value);
      switch (shape_of(s)) {
        case StmtShape::StoresSelf: add({RangeOpKind::Store, type_of(s.type), s.index}); break;
        case StmtShape::Chooses: branch(s); break;
        case StmtShape::StoresBind:
        case StmtShape::Evaluates: BIP_UNREACHABLE("clause_ranges takes neither stores into ports nor calls");
      }
    }
  }

 private:
  void branch(const Stmt& s) {
    const std::size_t start = out_.size();
    add({RangeOpKind::Branch, rt::CellType::Bool});
    body(s.then_body);
    const std::size_t middle = out_.size();
    body(s.else_body);
    out_[start].row = static_cast<std::uint32_t>(middle - start - 1);
    out_[start].otherwise = static_cast<std::uint32_t>(out_.size() - middle);
  }
  static bool is_number(Type type) { return type == Type::Int || type == Type::Bool || type == Type::Float; }
  void add(const RangeOp& op) { out_.push_back(op); }
  void any(Type type) { add({RangeOpKind::Any, type_of(type)}); }
  void load(RangeOpKind kind, const Expr& e) {
    if (is_number(e.type)) add({kind, type_of(e.type), e.index});
    else any(e.type);
  }
  void unary(RangeOpKind kind, const Expr& e) {
    value(e.a);
    add({kind, type_of(e.type)});
  }
  void binary(RangeOpKind kind, const Expr& e, ExprId first, ExprId second) {
    if (!is_number(code_.exprs[first].type)) return any(e.type);
    value(first);
    value(second);
    add({kind, type_of(e.type)});
  }

  const CodeTable& code_;
  std::vector<RangeOp>& out_;
};

}  // namespace

// How many values the code leaves on the stack of rt::RangeMachine; -1: it takes one that is not there. For assertions.
[[maybe_unused]] static int final_depth(const std::vector<RangeOp>& code) {
  int depth = 0;
  for (const RangeOp& op : code) {
    switch (op.kind) {
      case RangeOpKind::Constant:
      case RangeOpKind::Any:
      case RangeOpKind::Own:
      case RangeOpKind::Bound: ++depth; break;
      case RangeOpKind::Neg:
      case RangeOpKind::Not:
        if (depth < 1) return -1;
        break;
      case RangeOpKind::Add:
      case RangeOpKind::Sub:
      case RangeOpKind::Mul:
      case RangeOpKind::And:
      case RangeOpKind::Or:
      case RangeOpKind::Eq:
      case RangeOpKind::Ne:
      case RangeOpKind::Lt:
      case RangeOpKind::Le:
        if (depth < 2) return -1;
        --depth;
        break;
      case RangeOpKind::Store:
      case RangeOpKind::Branch:
        if (depth < 1) return -1;
        --depth;
        break;
    }
  }
  return depth;
}

std::optional<ClauseRanges> clause_ranges(const CodeTable& code, const Clause& clause) {
  for (const CodeFacts& facts : {code_facts(code, clause.guard, StmtId{}), code_facts(code, ExprId{}, clause.up)}) {
    if (facts.may_fault || facts.writes_binds) return std::nullopt;
  }
  ClauseRanges ranges;
  if (clause.guard.is_valid()) RangeCodeWriter(code, ranges.guard).value(clause.guard);
  RangeCodeWriter(code, ranges.up).body(clause.up);
  BIP_ASSERT(final_depth(ranges.guard) == (clause.guard.is_valid() ? 1 : 0) && final_depth(ranges.up) == 0,
             "ranges of a clause leave {} values", final_depth(ranges.up));
  return ranges;
}

}  // namespace bip::lower
