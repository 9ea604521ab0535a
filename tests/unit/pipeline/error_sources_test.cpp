// Whether a run can end in an error at all: priorities do only if a connector comes after itself.
#include "compiler/pipeline/error_sources.hpp"

#include <catch2/catch.hpp>
#include <string>

#include "compiler/pipeline/pipeline.hpp"
#include "tests/unit/pipeline/model_file.hpp"

using namespace bip;
using namespace bip::pipeline;

namespace {

bool can_end_in_error_with(const std::string& root) {
  const ModelFile file(R"(package m
  port type Signal()
  connector type One(Signal p)
    define p
  end
  connector type Up(Signal p)
    export port Signal e()
    define p
  end
  atom type A()
    export data bool is_on = true
    export port Signal p()
    place l
    initial to l
    on p from l to l
  end
  compound type Root()
    component A a()
    component A b()
    component A c()
)" + root + "  end\nend\n");
  Compilation c(CompileOptions{.root = "Root()", .verify_each = true});
  REQUIRE(compile(c, file.path(), Stage::Image));
  return can_end_in_error(*c.system);
}

}  // namespace

TEST_CASE("priorities without a cycle end no run in an error") {
  const std::string connectors = "    connector One x(a.p)\n    connector One y(b.p)\n    connector One z(c.p)\n";
  CHECK_FALSE(can_end_in_error_with(connectors));
  CHECK_FALSE(can_end_in_error_with(connectors + "    priority one x:* < y:*\n    priority two y:* < z:*\n"));
  CHECK_FALSE(can_end_in_error_with(connectors + "    priority one x:* < y:*\n    priority two x:* < z:*\n"));
}

TEST_CASE("priorities that may close a cycle may end a run in an error") {
  const std::string connectors =
      "    connector One x(a.p)\n    connector Up u(b.p)\n    connector One y(u.e)\n    connector One z(c.p)\n";
  CHECK(can_end_in_error_with(connectors + "    priority one x:* < z:* provided (a.is_on)\n"
                                           "    priority two z:* < x:* provided (b.is_on)\n"));
  CHECK(can_end_in_error_with(connectors + "    priority one *:* < z:*\n"));
  CHECK_FALSE(can_end_in_error_with(connectors + "    priority one x:* < y:*\n"));
}
