// Whether a run can end in an error at all: priorities do only if a connector comes after itself, two transitions only
// if their guards can hold together, and so on.
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

/// An atom type with these members, of which `x` and `y` are components, with the parameter 3 and 5.
bool atoms_can_end_in_error(const std::string& members) {
  const ModelFile file(R"(package m
  port type Signal()
  connector type One(Signal p)
    define p
  end
  atom type A(int most)
    data int n = 0, k = 0
    export port Signal p()
    place L, M
    initial to L
)" + members + R"(  end
  compound type Root()
    component A x(3), y(5)
    connector One c(x.p)
  end
end
)");
  Compilation c(CompileOptions{.root = "Root()", .verify_each = true});
  REQUIRE(compile(c, file.path(), Stage::Image));
  return can_end_in_error(*c.system);
}
bool guards_can_hold_together(const std::string& first, const std::string& second) {
  return atoms_can_end_in_error("    on p from L to L provided (" + first +
                                ") do { n = n + 1; }\n    on p from L to M provided (" + second + ")\n");
}

}  // namespace

TEST_CASE("two transitions of a port are an error only if their guards can hold together") {
  CHECK_FALSE(guards_can_hold_together("n > 1", "n == 1"));
  CHECK_FALSE(guards_can_hold_together("n < most", "n >= most"));
  CHECK_FALSE(guards_can_hold_together("n < most", "most <= n"));
  CHECK_FALSE(guards_can_hold_together("n + k == most", "n + k != most"));
  CHECK_FALSE(guards_can_hold_together("!(n < 3 || k > 2)", "n <= 2 || k == 3 && n < 3"));
  CHECK_FALSE(guards_can_hold_together("n == 1 || n == 2", "3 <= n"));
  CHECK_FALSE(guards_can_hold_together("n > 2147483646 && k == 1", "2147483647 > n"));
  CHECK_FALSE(guards_can_hold_together("n + 1 > 2 && 2 > k", "k > 1"));
  CHECK_FALSE(guards_can_hold_together("n != 1", "1 == n"));
  CHECK(guards_can_hold_together("n > 1", "n == 2"));
  CHECK(guards_can_hold_together("n < most", "n <= most"));
  CHECK(guards_can_hold_together("n != 1", "n != 2"));
  CHECK(guards_can_hold_together("n < 3", "k >= 3"));
  CHECK(guards_can_hold_together("!(n < 3 && k > 2)", "n < 3"));
  CHECK(guards_can_hold_together("n == 1 || n == 2", "n >= 2"));
  CHECK(guards_can_hold_together("n + 1 > n", "n + 1 >= n"));
}

TEST_CASE("a comparison with no number is false, and its negation is true") {
  const std::string data = "    data float x = 0.0, z = 0.0\n";
  CHECK_FALSE(atoms_can_end_in_error(
      data + "    on p from L to L provided (x < 1.5)\n    on p from L to M provided (x >= 1.5)\n"));
  CHECK_FALSE(atoms_can_end_in_error(
      data + "    on p from L to L provided (x < 1.5)\n    on p from L to M provided (!(x < 1.5))\n"));
  CHECK(atoms_can_end_in_error(
      data + "    on p from L to L provided (!(x < 1.5))\n    on p from L to M provided (!(x >= 1.5))\n"));
  CHECK(atoms_can_end_in_error(data +
                               "    on p from L to L provided (x != z)\n    on p from L to M provided (!(x < z))\n"));
}

TEST_CASE("a division is an error only by what may be 0 or -1 in some component") {
  const std::string step = "    on p from L to M do { n = n % most; }\n";
  CHECK_FALSE(atoms_can_end_in_error(step));
  CHECK(atoms_can_end_in_error("    on p from L to M do { n = 7 / n; }\n"));
  CHECK(atoms_can_end_in_error("    on p from L to M do { n = n % most; }\n    invariant small provided (n < 3)\n"));
  CHECK(atoms_can_end_in_error("    on p from L to M do { n = n % most; most = 0; }\n"));
}

TEST_CASE("invariants and guards of time are an error only if they divide, clocks if they get too much") {
  const std::string clock = "    clock t\n";
  CHECK_FALSE(atoms_can_end_in_error(
      clock + "    on p from L to M provided (t >= 2) do { t = 0; }\n    invariant i at L provided (t <= most)\n"));
  CHECK_FALSE(atoms_can_end_in_error(
      clock + "    on p from L to M provided (t < 2)\n    on p from L to L provided (t >= 2) do { t = n; }\n"));
  CHECK(atoms_can_end_in_error(clock +
                               "    on p from L to M provided (t <= 2)\n    on p from L to L provided (t >= 2)\n"));
  CHECK(atoms_can_end_in_error(clock + "    on p from L to M provided (t >= 7 / n)\n"));
  CHECK(atoms_can_end_in_error(clock + "    data float x = 0.0\n    on p from L to M do { t = x; }\n"));
  CHECK(atoms_can_end_in_error("    clock t unit day\n    on p from L to M do { t = n; }\n"));
}

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
