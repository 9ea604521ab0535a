// Symbolic values of cells, see values.hpp. Both branches of an `if` are executed, one after the other on the same
// cells; where they differ, a maximum or minimum of two values is recognised. Expressions recurse (`validate` limits
// their depth). Branches recurse as well, with a limit of their own, because chains of `else if` have none.
#include "compiler/steps/values.hpp"

#include <algorithm>

#include "compiler/model/operators.hpp"
#include "compiler/model/statements.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::steps {

using lower::ReductionOp;

namespace {

constexpr u32 kMostBranches = 32;  // within one another
constexpr std::size_t kMostElements = 1u << 17;

bool is_idempotent(ReductionOp by) {
  return by == ReductionOp::Min || by == ReductionOp::Max || by == ReductionOp::And || by == ReductionOp::Or;
}

}  // namespace

void Values::begin() {
  for (const u32 cell : cells_) now_[cell] = rt::kNone;
  cells_.clear();
  values_.clear();
  before_.clear();
  is_known_ = true;
  has_read_zero_ = false;
}

u32 Values::add(Value value) {
  BIP_ASSERT(value.kind != Kind::Joined || (value.a < values_.size() && value.b < values_.size()),
             "value {} is joined of ones that are not there", values_.size());
  values_.push_back(value);
  return static_cast<u32>(values_.size() - 1);
}

u32 Values::in(u32 cell) {
  BIP_ASSERT(cell < now_.size(), "cell {} of {}", cell, now_.size());
  if (now_[cell] == rt::kNone) {
    cells_.push_back(cell);
    now_[cell] = add({Kind::Old, {}, cell, 0});
  }
  return now_[cell];
}

void Values::set(u32 cell, u32 value) {
  const u32 before = in(cell);
  if (depth_ > 0) before_.emplace_back(cell, before);
  now_[cell] = value;
}

void Values::zero(u32 first, u32 count) {
  for (u32 cell = first; cell < first + count; ++cell) set(cell, add({Kind::Zero, {}, 0, 0}));
}

u32 Values::read(u32 cell) {
  const u32 value = in(cell);
  if (values_[value].kind != Kind::Zero) return value;
  has_read_zero_ = true;
  return opaque();
}

u32 Values::joined(ReductionOp by, u32 a, u32 b) {
  if (a == b && is_idempotent(by)) return a;
  return add({Kind::Joined, by, a, b});
}

u32 Values::expr(ExprId id) {
  const Expr& e = code_.exprs[id];
  if (e.op == Op::LoadSelf) return read(self_ + e.index);
  if (e.op == Op::LoadBind) return read(bind_[e.index]);
  const int operands = operand_count(e.op);
  if (operands == 0) return opaque();
  const u32 a = expr(e.a);
  if (operands == 1) return opaque();
  const u32 b = expr(e.b);
  const bool is_int = e.type == Type::Int;
  switch (e.op) {
    case Op::Add: return is_int ? joined(ReductionOp::Add, a, b) : opaque();
    case Op::Mul: return is_int ? joined(ReductionOp::Mul, a, b) : opaque();
    // Nothing faults, so that the second operand may be evaluated always.
    case Op::BitAnd:
    case Op::And: return joined(ReductionOp::And, a, b);
    case Op::BitOr:
    case Op::Or: return joined(ReductionOp::Or, a, b);
    case Op::BitXor: return joined(ReductionOp::Xor, a, b);
    case Op::Sub:
      BIP_LEAF_OPS(BIP_OP_CASE)
      BIP_UNARY_OPS(BIP_OP_CASE)
      BIP_DIVISION_OPS(BIP_OP_CASE)
      BIP_COMPARISON_OPS(BIP_OP_CASE)
      break;
  }
  return opaque();
}

u32 Values::either(ExprId condition, u32 yes, u32 no) {
  if (yes == no) return yes;
  for (const u32 value : {yes, no}) has_read_zero_ = has_read_zero_ || values_[value].kind == Kind::Zero;
  const Expr& e = code_.exprs[condition];
  if (!is_order(e.op) || code_.exprs[e.a].type != Type::Int) return opaque();
  const u32 a = expr(e.a), b = expr(e.b);
  const bool greater = e.op == Op::Gt || e.op == Op::Ge;
  if (yes == a && no == b) return joined(greater ? ReductionOp::Max : ReductionOp::Min, a, b);
  if (yes == b && no == a) return joined(greater ? ReductionOp::Min : ReductionOp::Max, a, b);
  return opaque();
}

// What was assigned since, each cell once; the cells hold again what they held.
Values::Assigned Values::take_back(std::size_t mark) {
  Assigned assigned;
  for (std::size_t i = mark; i < before_.size(); ++i) assigned.emplace_back(before_[i].first, now_[before_[i].first]);
  std::sort(assigned.begin(), assigned.end());
  assigned.erase(std::unique(assigned.begin(), assigned.end()), assigned.end());
  for (; before_.size() > mark; before_.pop_back()) now_[before_.back().first] = before_.back().second;
  BIP_ASSERT(before_.size() == mark, "{} assignments, not {}", before_.size(), mark);
  return assigned;
}

void Values::branch(const Stmt& s) {
  if (depth_ == kMostBranches) {
    is_known_ = false;
    return;
  }
  (void)expr(s.value);
  ++depth_;
  BIP_ASSERT(depth_ <= kMostBranches, "{} branches within each other", depth_);
  const std::size_t mark = before_.size();
  run(s.then_body, self_, bind_);
  Assigned yes = take_back(mark);
  run(s.else_body, self_, bind_);
  const Assigned no = take_back(mark);
  --depth_;
  // Both lists with all cells of both.
  Assigned merged;
  for (std::size_t i = 0, j = 0; i < yes.size() || j < no.size();) {
    const bool takes_yes = j == no.size() || (i < yes.size() && yes[i].first <= no[j].first);
    const u32 cell = takes_yes ? yes[i].first : no[j].first;
    const u32 if_yes = takes_yes ? yes[i++].second : in(cell);
    const u32 if_no = j < no.size() && no[j].first == cell ? no[j++].second : in(cell);
    merged.emplace_back(cell, either(s.value, if_yes, if_no));
  }
  for (const auto& [cell, value] : merged) set(cell, value);
}

void Values::run(StmtId body, u32 self, const u32* bind) {
  self_ = self;
  bind_ = bind;
  for (StmtId id = body; id.is_valid() && is_known_; id = code_.stmts[id].next) {
    const Stmt& s = code_.stmts[id];
    switch (shape_of(s)) {
      case StmtShape::StoresSelf: set(self + s.index, expr(s.value)); break;
      case StmtShape::StoresBind: set(bind[s.index], expr(s.value)); break;
      case StmtShape::Chooses: branch(s); break;
      case StmtShape::Evaluates: is_known_ = false; break;
    }
  }
}

bool Values::elements(u32 value, std::vector<u32>& out) const {
  out.clear();
  const ReductionOp by = values_[value].by;
  if (values_[value].kind != Kind::Joined) return false;
  std::vector<u32> todo{value};
  while (!todo.empty()) {
    const Value& at = values_[todo.back()];
    todo.pop_back();
    if (at.kind == Kind::Joined && at.by == by) {
      todo.insert(todo.end(), {at.b, at.a});
    } else if (at.kind == Kind::Old && out.size() < kMostElements) {
      out.push_back(at.a);
    } else {
      return false;
    }
  }
  std::sort(out.begin(), out.end());
  if (is_idempotent(by)) out.erase(std::unique(out.begin(), out.end()), out.end());
  return true;
}

}  // namespace bip::steps
