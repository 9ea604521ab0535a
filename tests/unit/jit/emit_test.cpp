// --emit=llvm and --emit=asm, and how long start-up takes (hidden: unit_jit "[.timing]").
#include <catch2/catch.hpp>

#include <chrono>
#include <cstdio>

#include "compiler/jit/jit.hpp"
#include "tests/unit/jit/units.hpp"

using namespace bip;

namespace {

void fill(test::Units& units, int count, unsigned seed) {
  std::mt19937 random(seed);
  for (int k = 0; k < count; ++k) {
    if (k % 2 == 0) {
      units.add_guard(units.random_expr(random, Type::Bool, 3));
    } else {
      units.add_action(units.random_body(random, 1));
    }
  }
}

}  // namespace

TEST_CASE("IR and assembly name every unit and relax nothing") {
  test::Units units;
  fill(units, 40, 5);
  for (const jit::OptLevel level : {jit::OptLevel::O0, jit::OptLevel::O2}) {
    const Result<std::string> ir = jit::emit_llvm(units.lowered(), level);
    if (!ir) FAIL(ir.error());
    const Result<std::string> assembly = jit::emit_asm(units.lowered(), level);
    if (!assembly) FAIL(assembly.error());
    CHECK((*ir).find("define") != std::string::npos);
    for (const lower::CodeUnit& unit : units.lowered().units) {
      CHECK((*ir).find("@" + unit.name + "(") != std::string::npos);
      CHECK((*assembly).find(unit.name + ":") != std::string::npos);
    }
    for (const char* flag : {" fast ", " nnan ", " contract ", " reassoc "})
      CHECK((*ir).find(flag) == std::string::npos);
    CHECK((*assembly).find("vfmadd") == std::string::npos);
  }
}

TEST_CASE("emitting twice gives the same text") {
  test::Units units;
  fill(units, 20, 6);
  const Result<std::string> once = jit::emit_llvm(units.lowered(), jit::OptLevel::O2);
  const Result<std::string> again = jit::emit_llvm(units.lowered(), jit::OptLevel::O2);
  REQUIRE(once);
  REQUIRE(again);
  CHECK(*once == *again);
}

TEST_CASE("start-up times", "[.timing]") {
  for (const int count : {1, 1, 100, 1000})
    for (const jit::OptLevel level : {jit::OptLevel::O0, jit::OptLevel::O2}) {
      test::Units units;
      fill(units, count, 7);
      lower::LoweredSystem& lowered = units.lowered();
      const auto begin = std::chrono::steady_clock::now();
      const Result<std::unique_ptr<jit::Jit>> jit = jit::Jit::compile(lowered, level);
      const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
      REQUIRE(jit);
      std::printf("%5d units at %s: %8.2f ms\n", count, level == jit::OptLevel::O0 ? "-O0" : "-O2", took.count());
    }
}
