// The pipeline as a library: products, errors, two compilations at once.
#include "compiler/pipeline/pipeline.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "compiler/base/write_file.hpp"
#include "compiler/pipeline/host_compiler.hpp"
#include "compiler/pipeline/roots.hpp"
#include "compiler/system/system.hpp"
#include "tests/unit/pipeline/model_file.hpp"

using namespace bip;
using namespace bip::pipeline;

namespace {

constexpr const char* kPipelineModel = R"(package m
  port type Signal()
  connector type Alone(Signal p) define p end
  atom type A(int n)
    data int x = 0
    export port Signal p()
    place S
    initial to S
    on p from S to S provided (x < n) do { x = x + 1; }
  end
  compound type Inner(int n)
    component A a(n)
    connector Alone c(a.p)
  end
  compound type First()
    component Inner i(1)
  end
  compound type Second()
    component Inner i(2)
  end
end
)";

}  // namespace

TEST_CASE("each stage leaves its product, and no later one") {
  const ModelFile file(kPipelineModel);
  Compilation c(CompileOptions{.root = "Inner(1 + 2)", .verify_each = true});
  REQUIRE(compile(c, file.path(), Stage::Model));
  REQUIRE(c.model);
  REQUIRE_FALSE(c.system);
  Compilation d(CompileOptions{.root = "Inner(1 + 2)", .verify_each = true});
  REQUIRE(compile(d, file.path(), Stage::Image));
  REQUIRE(d.lowered != nullptr);
  REQUIRE(d.root_name == "Inner(1 + 2)");
  REQUIRE(d.system->atoms.size() == 1);
  // A pass validates its own product: validation is no row of its own.
  REQUIRE(d.times.size() == 7);
}

TEST_CASE("two compilations never meet") {
  const ModelFile file(kPipelineModel);
  Compilation good(CompileOptions{.root = "Inner(1)"});
  Compilation bad(CompileOptions{.root = "Nothing()"});
  REQUIRE_FALSE(compile(bad, file.path(), Stage::Image));
  REQUIRE(compile(good, file.path(), Stage::Image));
  REQUIRE(bad.diags.has_errors());
  REQUIRE_FALSE(good.diags.has_errors());
}

TEST_CASE("check instantiates every root that there could be; run wants one") {
  const ModelFile file(kPipelineModel);
  Compilation c(CompileOptions{});
  REQUIRE(check(c, file.path()));
  REQUIRE(root_candidates(*c.model) == std::vector<std::string>{"First", "Second"});
  Compilation d(CompileOptions{});
  REQUIRE_FALSE(compile(d, file.path(), Stage::Image));
}

TEST_CASE("a file that is not there is a diagnostic, not a crash") {
  Compilation c(CompileOptions{});
  REQUIRE_FALSE(compile(c, "/nowhere/m.bip", Stage::Image));
  REQUIRE(c.diags.error_count() == 1);
  REQUIRE_FALSE(check(c, "/nowhere/m.bip"));
}

TEST_CASE("the host's compiler: $CXX with arguments, or what is there") {
  std::string tried;
  ::setenv("CXX", "sh -c true", 1);
  REQUIRE(find_host_compiler(tried) == std::vector<std::string>{"sh", "-c", "true"});
  ::setenv("CXX", "no-such-compiler-at-all", 1);
  REQUIRE(find_host_compiler(tried).empty());
  REQUIRE(tried == "`no-such-compiler-at-all` of $CXX");
  ::unsetenv("CXX");
}

TEST_CASE("programs: exit codes, signals, and none at all") {
  REQUIRE(*run_program({"sh", "-c", "exit 3"}) == 3);
  REQUIRE(*run_program({"sh", "-c", "kill -TERM $$"}) == 128 + 15);
  REQUIRE_FALSE(run_program({"/nowhere/program"}));
}

TEST_CASE("files are replaced whole, keep their permissions, and links stay links") {
  const auto made = TemporaryDirectory::make();
  REQUIRE(made);
  const std::string directory = (*made).path();
  const std::string path = directory + "/a";
  REQUIRE(write_file(path, "one"));
  std::filesystem::permissions(path, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  std::filesystem::create_symlink("a", directory + "/link");
  REQUIRE(write_file(directory + "/link", "two"));
  REQUIRE(std::filesystem::is_symlink(directory + "/link"));
  std::string text;
  std::ifstream(path) >> text;
  REQUIRE(text == "two");
  REQUIRE(std::filesystem::status(path).permissions() ==
          (std::filesystem::perms::owner_read | std::filesystem::perms::owner_write));
  REQUIRE_FALSE(write_file(directory + "/no/such/folder/a", "x"));
  REQUIRE(std::distance(std::filesystem::directory_iterator(directory), {}) == 2);
}
