// Machine code on disk (compiler/base/content_cache.hpp): it is what would have been made.
#include <catch2/catch.hpp>

#include <fstream>

#include "compiler/jit/jit.hpp"
#include "tests/unit/base/scratch_folder.hpp"
#include "tests/unit/jit/units.hpp"

namespace fs = std::filesystem;

namespace bip::jit {

TEST_CASE("a second compilation takes its code from the cache, and it is the same code") {
  const testing::ScratchFolder folder;
  test::Units units;
  std::mt19937 random(7);
  for (int k = 0; k < 20; ++k) {
    units.add_guard(units.random_expr(random, Type::Bool, 4));
    units.add_action(units.random_body(random, 3));
  }
  const auto compile = [&](OptLevel level, const std::string& version) {
    MadeCode made;
    const auto jit =
        Jit::compile(units.lowered(), {.level = level, .cache_folder = folder.path(), .version = version}, made);
    REQUIRE(jit);
    REQUIRE(made.codes.size() == units.size());
    return made;
  };
  CHECK(compile(OptLevel::O2, "1").from_cache == 0);
  const MadeCode second = compile(OptLevel::O2, "1");
  CHECK(second.from_cache == second.modules);
  CHECK(second.modules == 1);
  // Another level, another version, other code: none of them are the same.
  CHECK(compile(OptLevel::O0, "1").from_cache == 0);
  CHECK(compile(OptLevel::O2, "2").from_cache == 0);
  units.add_guard(units.random_expr(random, Type::Bool, 2));
  CHECK(compile(OptLevel::O2, "1").from_cache == 0);
  // A broken file is told and made anew.
  for (const fs::path& file : folder.files()) std::ofstream(file, std::ios::binary) << "broken";
  const MadeCode again = compile(OptLevel::O2, "1");
  CHECK(again.from_cache == 0);
  CHECK(again.broken_files.size() == 1);
  CHECK(compile(OptLevel::O2, "1").from_cache == 1);
}

}  // namespace bip::jit
