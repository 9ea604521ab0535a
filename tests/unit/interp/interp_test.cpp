// The interpreter's arithmetic, its faults and its statements.
#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

#include "compiler/interp/interp.hpp"
#include "tests/unit/lower/hand_built.hpp"

using namespace bip;
using bip::test::Code;

namespace {

constexpr std::int32_t kMin = std::numeric_limits<std::int32_t>::min();
constexpr std::int32_t kMax = std::numeric_limits<std::int32_t>::max();

// Runs `body` as the initial action of one atom over `cells`.
std::int32_t run(System& s, StmtId body, rt::Cell* cells) {
  s.atom_types[AtomTypeId(0u)].initial_action = body;
  const auto lowered = lower::lower(s, "Root");
  const interp::Interpreter interpreter(*lowered);
  const rt::Code code = lowered->image.codes[0];
  return code.fn(code.context, cells, cells, nullptr);
}

// An action that stores the expression in the atom's only cell.
std::int32_t stored(const CodeTable& code, ExprId id, rt::Cell& out) {
  System s = test::one_atom({test::variable("x", code.exprs[id].type)});
  s.code = code;
  return run(s, Code{s.code}.set(0, id), &out);
}
std::int32_t int_of(const CodeTable& code, ExprId id) {
  rt::Cell out{};
  REQUIRE(stored(code, id, out) == 1);
  CHECK(out.bits <= 0xffffffffu);
  return out.i;
}
double float_of(const CodeTable& code, ExprId id) {
  rt::Cell out{};
  REQUIRE(stored(code, id, out) == 1);
  return out.f;
}
std::int32_t status_of(const CodeTable& code, ExprId id) {
  rt::Cell out{};
  return stored(code, id, out);
}

}  // namespace

TEST_CASE("int arithmetic wraps at 32 bits") {
  CodeTable t;
  Code c{t};
  CHECK(int_of(t, c.binary(Op::Add, c.i(kMax), c.i(1))) == kMin);
  CHECK(int_of(t, c.binary(Op::Sub, c.i(kMin), c.i(1))) == kMax);
  CHECK(int_of(t, c.binary(Op::Mul, c.i(kMax), c.i(kMax))) == 1);
  CHECK(int_of(t, c.binary(Op::Mul, c.i(65536), c.i(65536))) == 0);
  CHECK(int_of(t, c.unary(Op::Neg, c.i(kMin))) == kMin);
  CHECK(int_of(t, c.unary(Op::BitNot, c.i(0))) == -1);
  CHECK(int_of(t, c.binary(Op::BitXor, c.i(-1), c.i(5))) == -6);
}

TEST_CASE("division truncates, % has the sign of the dividend") {
  CodeTable t;
  Code c{t};
  CHECK(int_of(t, c.binary(Op::Div, c.i(-7), c.i(2))) == -3);
  CHECK(int_of(t, c.binary(Op::Mod, c.i(-7), c.i(2))) == -1);
  CHECK(int_of(t, c.binary(Op::Mod, c.i(7), c.i(-2))) == 1);
  CHECK(int_of(t, c.binary(Op::Div, c.i(kMin), c.i(1))) == kMin);
  CHECK(int_of(t, c.binary(Op::Mod, c.i(kMax), c.i(-1))) == 0);
}

TEST_CASE("a division faults at its own expression") {
  CodeTable t;
  Code c{t};
  const ExprId by_zero = c.binary(Op::Div, c.i(1), c.i(0));
  const ExprId overflow = c.binary(Op::Mod, c.i(kMin), c.i(-1));
  // Divisions are the sites, in the order of their rows.
  CHECK(status_of(t, by_zero) == rt::fault_status(0, rt::FaultKind::DivisionByZero));
  CHECK(status_of(t, overflow) == rt::fault_status(1, rt::FaultKind::DivisionOverflow));
  CHECK(status_of(t, c.binary(Op::Add, by_zero, overflow)) == rt::fault_status(0, rt::FaultKind::DivisionByZero));
  CHECK(status_of(t, c.binary(Op::Add, overflow, by_zero)) == rt::fault_status(1, rt::FaultKind::DivisionOverflow));
}

TEST_CASE("&& and || do not evaluate what is decided") {
  CodeTable t;
  Code c{t};
  const ExprId fault = c.binary(Op::Eq, c.binary(Op::Div, c.i(1), c.i(0)), c.i(1));
  CHECK(int_of(t, c.binary(Op::And, c.b(false), fault)) == 0);
  CHECK(int_of(t, c.binary(Op::Or, c.b(true), fault)) == 1);
  CHECK(status_of(t, c.binary(Op::And, c.b(true), fault)) > 1);
  CHECK(status_of(t, c.binary(Op::Or, c.b(false), fault)) > 1);
  CHECK(status_of(t, c.binary(Op::And, fault, c.b(false))) > 1);
  CHECK(int_of(t, c.binary(Op::And, c.b(true), c.b(true))) == 1);
}

TEST_CASE("floats are IEEE doubles and do not fault") {
  CodeTable t;
  Code c{t};
  CHECK(std::isinf(float_of(t, c.binary(Op::Div, c.f(1), c.f(0)))));
  const ExprId nan = c.binary(Op::Div, c.f(0), c.f(0));
  CHECK(int_of(t, c.binary(Op::Eq, nan, nan)) == 0);
  CHECK(int_of(t, c.binary(Op::Ne, nan, nan)) == 1);
  CHECK(int_of(t, c.binary(Op::Le, nan, c.f(1))) == 0);
  CHECK(std::signbit(float_of(t, c.unary(Op::Neg, c.f(0)))));
  CHECK(float_of(t, c.binary(Op::Mul, c.unary(Op::IntToFloat, c.i(3)), c.f(0.1))) == 3 * 0.1);
  CHECK(int_of(t, c.binary(Op::Eq, c.s("a"), c.s("a"))) == 1);
  CHECK(int_of(t, c.binary(Op::Ne, c.s("a"), c.s("b"))) == 1);
}

TEST_CASE("statements run in order, nested ifs included") {
  System s = test::one_atom({test::variable("x", Type::Int), test::variable("y", Type::Int)});
  Code c{s.code};
  const StmtId inner = c.when(c.binary(Op::Gt, c.self(0), c.i(5)), c.set(1, c.i(1)), c.set(1, c.i(2)));
  const StmtId outer = c.when(c.binary(Op::Gt, c.self(0), c.i(0)), inner, c.set(1, c.i(3)));
  const StmtId body =
      c.body({c.set(0, c.binary(Op::Add, c.self(0), c.i(1))), outer, c.set(0, c.binary(Op::Mul, c.self(1), c.i(10)))});
  for (const auto& [x, y] : {std::pair{9, 1}, std::pair{3, 2}, std::pair{-4, 3}}) {
    rt::Cell cells[2] = {};
    cells[0].bits = static_cast<std::uint32_t>(x);
    CHECK(run(s, body, cells) == 1);
    CHECK(cells[1].i == y);
    CHECK(cells[0].i == 10 * y);
  }
}

TEST_CASE("the first fault ends an action: earlier stores stay, later ones do not happen") {
  System s = test::one_atom({test::variable("x", Type::Int), test::variable("y", Type::Int)});
  Code c{s.code};
  const ExprId unused = c.binary(Op::Div, c.i(4), c.i(2));
  const ExprId fault = c.binary(Op::Div, c.i(1), c.self(1));
  const StmtId branch = c.when(c.b(true), c.body({c.set(0, fault), c.set(0, c.i(8))}));
  const StmtId body = c.body({c.set(0, c.i(7)), branch, c.set(1, unused)});
  rt::Cell cells[2] = {};
  CHECK(run(s, body, cells) == rt::fault_status(1, rt::FaultKind::DivisionByZero));
  CHECK(cells[0].i == 7);
  CHECK(cells[1].i == 0);
}

TEST_CASE("stores of ints keep the upper bits of a cell zero") {
  System s = test::one_atom({test::variable("x", Type::Int)});
  Code c{s.code};
  rt::Cell cells[1] = {};
  CHECK(run(s, c.set(0, c.i(-1)), cells) == 1);
  CHECK(cells[0].bits == 0xffffffffu);
}

TEST_CASE("connector code reads and writes through its bindings") {
  const System s = test::producers(2);
  const auto lowered = lower::lower(s, "Root");
  const interp::Interpreter interpreter(*lowered);
  const rt::Image& im = lowered->image;
  std::vector<rt::Cell> all(im.cell_count);
  all[1].i = 4;
  all[3].i = 5;
  const rt::Connector& sum = im.connectors[0];
  const rt::Code up = im.codes[im.connector_types[0].clauses[0].up];
  CHECK(up.fn(up.context, &all[sum.first_cell], all.data(), &im.binds.rows.data[sum.binds].cell) == 1);
  CHECK(all[sum.first_cell].i == 9);
  const rt::Connector& take = im.connectors[1];
  const rt::Clause& clause = im.connector_types[1].clauses[0];
  const rt::Code guard = im.codes[clause.guard];
  const rt::Code down = im.codes[clause.down];
  CHECK(guard.fn(guard.context, nullptr, all.data(), &im.binds.rows.data[take.binds].cell) == 1);
  CHECK(down.fn(down.context, nullptr, all.data(), &im.binds.rows.data[take.binds].cell) == 1);
  CHECK(all[im.atoms[2].first_cell + 1].i == 9);
}
