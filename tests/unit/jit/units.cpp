// Code units by hand: see units.hpp.
#include "tests/unit/jit/units.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <iterator>
#include <limits>

namespace bip::test {
namespace {

std::size_t below(std::mt19937& random, std::size_t n) { return random() % n; }
template <class T, std::size_t N>
T pick(std::mt19937& random, const std::array<T, N>& from) {
  return from[below(random, N)];
}
constexpr std::array<Type, 4> kTypes{Type::Int, Type::Bool, Type::Float, Type::String};

}  // namespace

Type type_of_variable(std::uint32_t index) { return kTypes[index / 2]; }

ExprId Units::constant(Type type, std::int32_t int_value, double float_value) {
  Expr e;
  e.op = type == Type::Int     ? Op::ConstInt
         : type == Type::Bool  ? Op::ConstBool
         : type == Type::Float ? Op::ConstFloat
                               : Op::ConstString;
  e.type = type;
  e.int_value = int_value;
  e.float_value = float_value;
  return code().exprs.push(e);
}
ExprId Units::load(Op o, std::uint32_t index) {
  Expr e;
  e.op = o;
  e.type = type_of_variable(index);
  e.index = index;
  return code().exprs.push(e);
}
ExprId Units::op(Op o, Type type, ExprId a, ExprId b) {
  Expr e;
  e.op = o;
  e.type = type;
  e.a = a;
  e.b = b;
  return code().exprs.push(e);
}
StmtId Units::store(StmtOp o, std::uint32_t index, ExprId value, StmtId next) {
  Stmt s;
  s.op = o;
  s.type = type_of_variable(index);
  s.index = index;
  s.value = value;
  s.next = next;
  return code().stmts.push(s);
}
StmtId Units::branch(ExprId condition, StmtId then_body, StmtId else_body, StmtId next) {
  Stmt s;
  s.op = StmtOp::If;
  s.value = condition;
  s.then_body = then_body;
  s.else_body = else_body;
  s.next = next;
  return code().stmts.push(s);
}

void Units::add_guard(ExprId expr) {
  lower::CodeUnit unit;
  unit.name = fmt::format("guard_{}", size());
  unit.kind = lower::CodeKind::Guard;
  unit.expr = expr;
  lowered_.units.push_back(unit);
}
void Units::add_action(StmtId body) {
  lower::CodeUnit unit;
  unit.name = fmt::format("action_{}", size());
  unit.kind = lower::CodeKind::Action;
  unit.body = body;
  lowered_.units.push_back(unit);
}

ExprId Units::random_expr(std::mt19937& random, Type type, int depth) {
  if (depth == 0 || below(random, 8) == 0) {
    const std::size_t kind = below(random, 3);
    const auto index = static_cast<std::uint32_t>(2 * static_cast<std::size_t>(type) + below(random, 2));
    if (kind != 0) return load(kind == 1 ? Op::LoadSelf : Op::LoadBind, index);
    if (type == Type::Int) return constant(type, edge_int(random));
    if (type == Type::Float) return constant(type, 0, edge_float(random));
    return constant(type, static_cast<std::int32_t>(below(random, type == Type::Bool ? 2 : 4)));
  }
  const auto sub = [&](Type t) { return random_expr(random, t, depth - 1); };
  if (type == Type::Int) {
    static constexpr std::array kOps{Op::Neg, Op::BitNot, Op::Add,    Op::Sub,   Op::Mul,
                                     Op::Div, Op::Mod,    Op::BitAnd, Op::BitOr, Op::BitXor};
    const Op o = pick(random, kOps);
    const ExprId a = sub(Type::Int);
    return o == Op::Neg || o == Op::BitNot ? op(o, type, a) : op(o, type, a, sub(Type::Int));
  }
  if (type == Type::Float) {
    static constexpr std::array kOps{Op::Neg, Op::IntToFloat, Op::Add, Op::Sub, Op::Mul, Op::Div};
    const Op o = pick(random, kOps);
    const ExprId a = sub(o == Op::IntToFloat ? Type::Int : Type::Float);
    return o == Op::Neg || o == Op::IntToFloat ? op(o, type, a) : op(o, type, a, sub(Type::Float));
  }
  if (type == Type::String) return random_expr(random, type, 0);
  static constexpr std::array kOps{Op::Not, Op::And, Op::Or, Op::Eq, Op::Ne, Op::Lt, Op::Gt, Op::Le, Op::Ge};
  const Op o = pick(random, kOps);
  if (o == Op::Not) return op(o, type, sub(Type::Bool));
  const Type operand = o == Op::And || o == Op::Or  ? Type::Bool
                       : o == Op::Eq || o == Op::Ne ? pick(random, kTypes)
                       : below(random, 2) == 0      ? Type::Int
                                                    : Type::Float;
  const ExprId a = sub(operand);
  return op(o, type, a, sub(operand));
}

StmtId Units::random_body(std::mt19937& random, int depth) {
  StmtId next;
  for (std::size_t k = below(random, 4) + 1; k > 0; --k) {
    if (depth > 0 && below(random, 3) == 0) {
      const ExprId condition = random_expr(random, Type::Bool, 3);
      const StmtId then_body = below(random, 6) == 0 ? StmtId() : random_body(random, depth - 1);
      const StmtId else_body = below(random, 2) == 0 ? StmtId() : random_body(random, depth - 1);
      next = branch(condition, then_body, else_body, next);
    } else {
      const auto index = static_cast<std::uint32_t>(below(random, kVariables));
      const ExprId value = random_expr(random, type_of_variable(index), 4);
      next = store(below(random, 2) == 0 ? StmtOp::StoreSelf : StmtOp::StoreBind, index, value, next);
    }
  }
  return next;
}

lower::LoweredSystem& Units::lowered() {
  lowered_.system = &system_;
  lowered_.code = &system_.code;
  lowered_.codes.assign(lowered_.units.size(), {});
  lowered_.site_of_expr.assign(code().exprs.size(), rt::kNone);
  std::uint32_t site = 0;
  for (std::size_t k = 0; k < code().exprs.size(); ++k) {
    const Expr& e = code().exprs.rows()[k];
    if ((e.op == Op::Div || e.op == Op::Mod) && e.type == Type::Int) lowered_.site_of_expr[k] = site++;
  }
  return lowered_;
}

std::int32_t edge_int(std::mt19937& random) {
  using Limits = std::numeric_limits<std::int32_t>;
  static constexpr std::array kEdges{
      0, 0, 1, -1, -1, 2, 7, -8, 255, 65536, Limits::max(), Limits::min(), Limits::min(), Limits::min() + 1};
  return below(random, 4) == 0 ? static_cast<std::int32_t>(random()) : pick(random, kEdges);
}
double edge_float(std::mt19937& random) {
  using Limits = std::numeric_limits<double>;
  static constexpr std::array kEdges{0.0,
                                     -0.0,
                                     1.0,
                                     -1.0,
                                     0.1,
                                     1.0 / 3,
                                     1e308,
                                     -1e308,
                                     1e16,
                                     4294967296.5,
                                     Limits::infinity(),
                                     -Limits::infinity(),
                                     Limits::quiet_NaN(),
                                     Limits::denorm_min(),
                                     Limits::min(),
                                     Limits::epsilon()};
  return below(random, 4) == 0 ? static_cast<double>(static_cast<std::int32_t>(random())) / 1000.0
                               : pick(random, kEdges);
}

Cells random_cells(std::mt19937& random) {
  Cells cells(kCells);
  for (std::uint32_t k = 0; k < kCells; ++k) {
    const Type type = type_of_variable(k < kVariables ? k : kCells - 1 - k);
    rt::Cell& cell = cells[k];
    cell.bits = 0;
    if (type == Type::Int) cell.bits = static_cast<std::uint32_t>(edge_int(random));
    if (type == Type::Bool) cell.bits = below(random, 2);
    if (type == Type::Float) cell.f = edge_float(random);
    if (type == Type::String) cell.bits = below(random, 4);
  }
  return cells;
}

std::string outcome(const rt::Code& code, Cells cells) {
  std::array<std::uint32_t, kVariables> bind{};
  for (std::uint32_t k = 0; k < kVariables; ++k) bind[k] = kCells - 1 - k;
  std::string text = fmt::format("{}", code.fn(code.context, cells.data(), cells.data(), bind.data()));
  for (std::uint32_t k = 0; k < kCells; ++k) {
    const bool is_float = type_of_variable(k < kVariables ? k : kCells - 1 - k) == Type::Float;
    if (is_float && std::isnan(cells[k].f)) {
      text += " nan";
    } else {
      fmt::format_to(std::back_inserter(text), " {:x}", cells[k].bits);
    }
  }
  return text;
}

}  // namespace bip::test
