// Which data is written, read, observed or out of sight, of small models with known answers.
#include "compiler/analysis/data_access.hpp"

#include <catch2/catch.hpp>

#include "tests/unit/system/instantiated.hpp"

namespace {

using Rows = std::vector<std::vector<std::uint32_t>>;

// Two atoms `A` with variables x, y, z; ports give (x, y). The connector type is the test's.
std::vector<bip::analysis::DataAccess> access_of(const std::string& connector, const std::string& transitions) {
  bip::test::Instantiated t(R"(package t
port type P(int v, int w)
)" + connector + R"(
atom type A(int k)
  data int x = 0, y = 0, z = 0
  export port P p(x, y)
  export port P q(y, z)
  place S
  initial to S
)" + transitions + R"(
end
compound type R()
  component A a(1)
  component A b(2)
  connector C c(a.p, b.q)
end
end
)");
  INFO(t.codes());
  REQUIRE(t.system);
  return bip::analysis::analyze_data_access(*t.system);
}

}  // namespace

TEST_CASE("a transfer writes the variables of the port that takes part, and reads those of the other one") {
  const auto rows = access_of("connector type C(P a, P b) define a b on a b down { b.v = a.w; } end",
                              "  on p from S to S\n  on q from S to S");
  REQUIRE(rows.size() == 1);
  // Row 0 is the parameter k; x, y, z are 1, 2, 3. b.v is y at the port q, a.w is y at the port p.
  CHECK(rows[0].written == Rows{{}, {2}});
  CHECK(rows[0].read == Rows{{2}, {}});
  CHECK(rows[0].observed == std::vector<std::uint8_t>{0, 0, 0, 0});
  CHECK(rows[0].unfollowed == std::vector<std::uint8_t>{0, 0, 0, 0});
}

TEST_CASE("a variable is observed if a guard reads it, or if an observed one is computed from it") {
  const auto rows =
      access_of("connector type C(P a, P b) define a b end",
                "  on p from S to S provided (x < 3) do { y = z; }\n  on q from S to S do { x = y + 1; }");
  CHECK(rows[0].observed == std::vector<std::uint8_t>{0, 1, 1, 1});
  const auto few = access_of("connector type C(P a, P b) define a b end",
                             "  on p from S to S provided (x < 3) do { y = x; }\n  on q from S to S do { z = y; }");
  CHECK(few[0].observed == std::vector<std::uint8_t>{0, 1, 0, 0});
}

TEST_CASE("a guard of a connector observes what it reads at a port") {
  const auto rows = access_of("connector type C(P a, P b) define a b on a b provided (a.v < b.w) end",
                              "  on p from S to S\n  on q from S to S");
  CHECK(rows[0].observed == std::vector<std::uint8_t>{0, 1, 0, 1});
  CHECK(rows[0].read == Rows{{1}, {3}});
  CHECK(rows[0].written == Rows{{}, {}});
}

TEST_CASE("a variable that C++ gets a reference to cannot be followed") {
  const auto rows = access_of("extern function bump(int)\nconnector type C(P a, P b) define a b end",
                              "  on p from S to S do { bump(y); }\n  on q from S to S");
  CHECK(rows[0].unfollowed == std::vector<std::uint8_t>{0, 0, 1, 0});
  const auto none = access_of("extern function look(const int)\nconnector type C(P a, P b) define a b end",
                              "  on p from S to S do { look(y); }\n  on q from S to S");
  CHECK(none[0].unfollowed == std::vector<std::uint8_t>{0, 0, 0, 0});
}
