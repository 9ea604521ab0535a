// Which exchanges of components preserve a property.
#include <catch2/catch.hpp>

#include <string>

#include "compiler/verify/property/symmetric_property.hpp"
#include "tools/gen/compiled.hpp"

namespace {

using namespace bip;

constexpr const char* kModel = R"(package p
  port type Number(int n)
  connector type One(Number a)
    define a
  end
  atom type Cell()
    data int n = 0
    data float f = 0.0
    export port Number go(n)
    place S, T
    initial to S
    on go from S to T
  end
  compound type Root()
    component Cell c[4]()
    for i in 0..4 connector One go[i](c[i].go)
  end
end
)";

bool is_preserved(const std::string& text, std::uint32_t a, std::uint32_t b) {
  const gen::Compiled c = gen::compile_texts({kModel});
  REQUIRE(c.problem.empty());
  const Result<verify::Property> property = verify::parse_property(text, *c.system);
  REQUIRE(property);
  return verify::PropertyImages(*property).is_preserved_by({{a, b}, {b, a}});
}

}  // namespace

TEST_CASE("a property is preserved by exchanges of components that it does not name") {
  CHECK(is_preserved("never c[0]@S", 1, 2));
  CHECK_FALSE(is_preserved("never c[0]@S", 0, 2));
}

TEST_CASE("operands of commutative and associative operators may change places") {
  const std::string all = "never c[0]@T && (c[1]@T || (c[2]@T || c[3]@T))";
  CHECK(is_preserved(all, 1, 2));
  CHECK(is_preserved(all, 2, 3));
  CHECK_FALSE(is_preserved(all, 0, 1));
  CHECK(is_preserved("always c[0].n + c[1].n * c[2].n == 1", 1, 2));
  CHECK_FALSE(is_preserved("always c[0].n + c[1].n * c[2].n == 1", 0, 1));
  CHECK(is_preserved("never c[0]@S && c[1]@S || c[2]@S && c[3]@S", 0, 1));
  // Two exchanges at once would preserve it, one alone does not.
  CHECK_FALSE(is_preserved("never c[0]@S && c[1]@S || c[2]@S && c[3]@S", 0, 2));
  CHECK(is_preserved("never c[0].n != c[1].n", 0, 1));
}

TEST_CASE("the order of other operands counts") {
  CHECK_FALSE(is_preserved("always c[0].n <= c[1].n", 0, 1));
  CHECK_FALSE(is_preserved("always c[0].n - c[1].n == 0", 0, 1));
  // Sums of floats are rounded after each addition.
  CHECK(is_preserved("always c[0].f + c[1].f < 1.0", 0, 1));
  CHECK_FALSE(is_preserved("always c[0].f + c[1].f + c[2].f < 1.0", 0, 2));
}

TEST_CASE("places, data and constants tell operands apart") {
  CHECK_FALSE(is_preserved("never c[0]@S && c[1]@T", 0, 1));
  CHECK_FALSE(is_preserved("never c[0].n == 1 && c[1].n == 2", 0, 1));
  CHECK(is_preserved("never can c[0].go && can c[1].go", 0, 1));
  CHECK(is_preserved("never can go[0]", 1, 2));
}
