// An emitted directory builds alone and its program prints what the interpreter's run prints.
#include <catch2/catch.hpp>

#include <cstdio>
#include <sstream>

#include "compiler/interp/interp.hpp"
#include "runtime/include/bip/run.hpp"
#include "tests/unit/emit_cpp/compiled.hpp"
#include "tests/unit/lower/hand_built.hpp"

using namespace bip;

namespace {

std::string text_of(const std::filesystem::path& path) {
  std::ifstream in(path);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::string interpreted(const System& s, const std::filesystem::path& scratch) {
  const auto lowered = lower::lower(s, "Root()");
  const interp::Interpreter interpreter(*lowered);
  rt::RunOptions options;
  options.seed = 7;
  options.has_seed = true;
  options.limit = 20;
  std::FILE* out = std::fopen((scratch / "interp.txt").c_str(), "w");
  REQUIRE(out != nullptr);
  const rt::RunResult result = rt::run(lowered->image, options, out, out);
  std::fclose(out);
  CHECK(result.exit_code == 0);
  CHECK(result.steps > 2);
  return text_of(scratch / "interp.txt");
}

}  // namespace

TEST_CASE("an emitted project builds alone and runs like the interpreter", "[slow]") {
  const test::ScratchDir scratch;
  const System s = test::producers(3);
  const auto lowered = lower::lower(s, "Root()");
  const std::string dir = (scratch.path() / "project").string();
  const Result<bool> written =
      emit_cpp::emit_project(*lowered, dir, (test::repository() / "runtime").string(), "my sum");
  REQUIRE(written);
  const std::string log = (scratch.path() / "log.txt").string();
  // Debug only because it builds faster; Ninja because tools/setup brings it, and a fresh machine has no make.
  const std::string build = "(cmake -G Ninja -S " + dir + " -B " + dir +
                            "/build -DCMAKE_BUILD_TYPE=Debug && cmake --build " + dir + "/build -j 2) >" + log +
                            " 2>&1";
  const int status = std::system(build.c_str());
  INFO(text_of(log));
  REQUIRE(status == 0);
  const std::string output = (scratch.path() / "emitted.txt").string();
  REQUIRE(std::system((dir + "/build/my_sum --seed 7 --limit 20 >" + output + " 2>&1").c_str()) == 0);
  CHECK(text_of(output) == interpreted(s, scratch.path()));
}

TEST_CASE("an emission without the runtime's sources fails with a reason") {
  const test::ScratchDir scratch;
  const System s = test::producers(1);
  const auto lowered = lower::lower(s, "Root()");
  const Result<bool> written =
      emit_cpp::emit_project(*lowered, scratch.path().string(), (scratch.path() / "none").string(), "x");
  REQUIRE(!written);
  CHECK_THAT(written.error(), Catch::Contains("runtime's sources"));
}
