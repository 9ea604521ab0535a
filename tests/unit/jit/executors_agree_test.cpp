// The interpreter, the JIT at -O0 and at -O2 do the same: same status, same 64 bits in every cell.
#include <catch2/catch.hpp>

#include "compiler/jit/jit.hpp"
#include "tests/unit/jit/units.hpp"

using namespace bip;

namespace {

std::unique_ptr<jit::Jit> compiled(lower::LoweredSystem& lowered, jit::OptLevel level) {
  Result<std::unique_ptr<jit::Jit>> jit = jit::Jit::compile(lowered, level);
  if (!jit) FAIL(jit.error());
  return std::move(*jit);
}

/// Runs every unit on every state with the three executors; returns how many runs ended in a fault.
std::size_t compare(test::Units& units, const std::vector<test::Cells>& states) {
  lower::LoweredSystem& lowered = units.lowered();
  const interp::Interpreter interpreter(lowered);
  const std::vector<rt::Code> expected = lowered.codes;
  const auto o0 = compiled(lowered, jit::OptLevel::O0);
  const std::vector<rt::Code> fast = lowered.codes;
  const auto o2 = compiled(lowered, jit::OptLevel::O2);
  std::size_t faults = 0;
  for (std::size_t k = 0; k < units.size(); ++k)
    for (const test::Cells& state : states) {
      const std::string wanted = test::outcome(expected[k], state);
      faults += wanted[1] != ' ' || wanted[0] > '1' ? 1 : 0;
      if (test::outcome(fast[k], state) != wanted)
        FAIL("-O0, " << lowered.units[k].name << "\n" << test::outcome(fast[k], state) << "\n" << wanted);
      if (test::outcome(lowered.codes[k], state) != wanted)
        FAIL("-O2, " << lowered.units[k].name << "\n" << test::outcome(lowered.codes[k], state) << "\n" << wanted);
    }
  return faults;
}

std::vector<test::Cells> random_states(std::mt19937& random, std::size_t count) {
  std::vector<test::Cells> states;
  for (std::size_t k = 0; k < count; ++k) states.push_back(test::random_cells(random));
  return states;
}

}  // namespace

TEST_CASE("every operator over edge values") {
  test::Units u;
  using enum Type;
  const auto self = [&](std::uint32_t k) { return u.load(Op::LoadSelf, k); };
  const auto result = [&](Type type, ExprId value) {
    u.add_action(u.store(StmtOp::StoreBind, 2 * static_cast<std::uint32_t>(type), value));
  };
  for (const Op op : {Op::Add, Op::Sub, Op::Mul, Op::Div, Op::Mod, Op::BitAnd, Op::BitOr, Op::BitXor})
    result(Int, u.op(op, Int, self(0), self(1)));
  for (const Op op : {Op::Add, Op::Sub, Op::Mul, Op::Div}) result(Float, u.op(op, Float, self(4), self(5)));
  for (const Op op : {Op::Eq, Op::Ne, Op::Lt, Op::Gt, Op::Le, Op::Ge}) {
    result(Bool, u.op(op, Bool, self(0), self(1)));
    result(Bool, u.op(op, Bool, self(4), self(5)));
  }
  for (const Op op : {Op::Eq, Op::Ne}) {
    result(Bool, u.op(op, Bool, self(2), self(3)));
    result(Bool, u.op(op, Bool, self(6), self(7)));
  }
  for (const Op op : {Op::And, Op::Or}) result(Bool, u.op(op, Bool, self(2), self(3)));
  result(Int, u.op(Op::Neg, Int, self(0)));
  result(Int, u.op(Op::BitNot, Int, self(0)));
  result(Float, u.op(Op::Neg, Float, self(4)));
  result(Float, u.op(Op::IntToFloat, Float, self(0)));
  result(Bool, u.op(Op::Not, Bool, self(2)));
  for (std::uint32_t k = 0; k < test::kVariables; ++k) {
    u.add_action(u.store(StmtOp::StoreBind, k, self(k)));
    u.add_action(u.store(StmtOp::StoreSelf, k, u.load(Op::LoadBind, k)));
  }
  std::mt19937 random(1);
  CHECK(compare(u, random_states(random, 2000)) > 100);
}

TEST_CASE("random guards agree") {
  test::Units u;
  std::mt19937 random(2);
  for (int k = 0; k < 800; ++k) u.add_guard(u.random_expr(random, Type::Bool, 2 + k % 6));
  CHECK(compare(u, random_states(random, 100)) > 100);
}

TEST_CASE("random actions agree") {
  test::Units u;
  std::mt19937 random(3);
  for (int k = 0; k < 700; ++k) u.add_action(u.random_body(random, k % 4));
  u.add_action({});
  CHECK(compare(u, random_states(random, 60)) > 100);
}

TEST_CASE("large units agree, and compile in time") {
  using enum Type;
  test::Units u;
  // More divisions than the passes are asked to look at, and nesting as deep as a System may have.
  ExprId quotient = u.load(Op::LoadSelf, 0), conjunction = u.load(Op::LoadSelf, 2);
  for (int k = 0; k < 300; ++k)
    quotient = u.op(k % 3 == 0 ? Op::Mod : Op::Div, Int, u.constant(Int, 1'000'000 + k),
                    u.op(Op::BitOr, Int, quotient, u.constant(Int, k % 7)));
  for (int k = 0; k < 1990; ++k)
    conjunction = u.op(k % 2 == 0 ? Op::And : Op::Or, Bool, conjunction,
                       u.op(Op::Lt, Bool, u.load(Op::LoadSelf, 0), u.constant(Int, k)));
  u.add_action(u.store(StmtOp::StoreSelf, 1, quotient));
  u.add_guard(conjunction);
  std::mt19937 random(4);
  compare(u, random_states(random, 200));
}

TEST_CASE("a division that is not reached does not fault") {
  using enum Type;
  for (const jit::OptLevel level : {jit::OptLevel::O0, jit::OptLevel::O2}) {
    test::Units u;
    const auto quotient = [&] {
      return u.op(Op::Eq, Bool, u.op(Op::Div, Int, u.load(Op::LoadSelf, 0), u.load(Op::LoadSelf, 1)),
                  u.constant(Int, 3));
    };
    u.add_guard(u.op(Op::And, Bool, u.load(Op::LoadSelf, 2), quotient()));
    u.add_guard(u.op(Op::Or, Bool, u.load(Op::LoadSelf, 2), quotient()));
    // The store before a fault stays, the one after it does not happen.
    u.add_action(
        u.store(StmtOp::StoreSelf, 2, u.constant(Bool, 1),
                u.store(StmtOp::StoreSelf, 3, quotient(), u.store(StmtOp::StoreSelf, 6, u.constant(String, 2)))));
    lower::LoweredSystem& lowered = u.lowered();
    const auto jit = compiled(lowered, level);
    test::Cells cells(test::kCells);
    const auto run = [&](std::size_t k, int a, int b, bool flag) {
      cells.assign(test::kCells, rt::Cell{.bits = 0});
      cells[0].bits = static_cast<std::uint32_t>(a);
      cells[1].bits = static_cast<std::uint32_t>(b);
      cells[2].bits = flag ? 1 : 0;
      return lowered.codes[k].fn(lowered.codes[k].context, cells.data(), cells.data(), nullptr);
    };
    CHECK(run(0, 7, 2, true) == 1);
    CHECK(run(0, 7, 0, false) == 0);
    CHECK(run(0, 7, 0, true) == rt::fault_status(0, rt::FaultKind::DivisionByZero));
    CHECK(run(1, 7, 0, true) == 1);
    CHECK(run(1, 7, 0, false) == rt::fault_status(1, rt::FaultKind::DivisionByZero));
    CHECK(run(1, std::numeric_limits<int>::min(), -1, false) == rt::fault_status(1, rt::FaultKind::DivisionOverflow));
    CHECK(run(2, 7, 0, false) == rt::fault_status(2, rt::FaultKind::DivisionByZero));
    CHECK(cells[2].bits == 1);
    CHECK(cells[6].bits == 0);
    CHECK(run(2, 7, 2, false) == 1);
    CHECK(cells[3].bits == 1);
    CHECK(cells[6].bits == 2);
  }
}

TEST_CASE("a store writes the whole cell") {
  for (const jit::OptLevel level : {jit::OptLevel::O0, jit::OptLevel::O2}) {
    test::Units u;
    StmtId body;
    for (const std::uint32_t k : {0u, 2u, 6u})
      body = u.store(StmtOp::StoreSelf, k, u.constant(test::type_of_variable(k), k == 0 ? -1 : 1), body);
    u.add_action(body);
    lower::LoweredSystem& lowered = u.lowered();
    const auto jit = compiled(lowered, level);
    test::Cells cells(test::kCells, rt::Cell{.bits = ~0ull});
    CHECK(lowered.codes[0].fn(nullptr, cells.data(), cells.data(), nullptr) == 1);
    CHECK(cells[0].bits == 0xffffffffull);
    CHECK(cells[2].bits == 1);
    CHECK(cells[6].bits == 1);
    CHECK(cells[1].bits == ~0ull);
  }
}
