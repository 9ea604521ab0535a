// Code as text: it says what the code says. Each condition is compiled, written, compiled again: the two systems are
// equal.
#include <catch2/catch.hpp>

#include <regex>

#include "compiler/graph/code_text.hpp"
#include "compiler/system/bsys.hpp"
#include "tests/unit/system/instantiated.hpp"

using namespace bip;

namespace {

std::string with_guard(const std::string& guard, const std::string& action) {
  return "package t\nport type P()\nconnector type One(P a) define a end\natom type A(int k)\n  data int x = 1, y = "
         "2\n  data bool b = true\n  data float f\n  data string s\n"
         "  export port P p()\n  place S\n  initial to S\n  on p from S to S provided (" +
         guard + ") do { " + action +
         " }\nend\ncompound type R()\n  component A a(1)\n  connector One c(a.p)\nend\nend\n";
}

struct Texts {
  std::string guard, action, system;
};

Texts texts_of(const std::string& guard, const std::string& action) {
  test::Instantiated t(with_guard(guard, action));
  INFO(guard << " " << action);
  REQUIRE(t.codes().empty());
  const AtomType& type = t.system->atom_types[AtomTypeId(std::size_t{0})];
  const graph::CodeNames names = graph::names_of(type);
  const std::string places = std::regex_replace(system::print(*t.system), std::regex(" @[0-9:]+"), "");
  return {graph::text_of(t.system->code, type.transitions[0].guard, names),
          graph::text_of(t.system->code, type.transitions[0].action, names), places};
}

}  // namespace

TEST_CASE("conditions are written with the parentheses that they need and no others") {
  for (const char* guard :
       {"x + y * 2 < 3", "(x + y) * 2 < 3", "x - (y - k) == 0", "x - y - k == 0", "!(b && x < y) || b",
        "b && (b || x < 1)", "-(x + 1) < -y", "(x & 3) == 1", "x / (y * 2) > x % 7", "~(x | y) != (x ^ y)",
        "(x < y) == b", "f < 0.5", "f < 2.0", "s == \"a\\\"b\\n\\\\\""}) {
    const Texts first = texts_of(guard, "");
    CHECK(first.guard == guard);
    CHECK(texts_of(first.guard, "").system == first.system);
  }
}

TEST_CASE("what the compiler adds is not written, what stands twice is") {
  CHECK(texts_of("f < 2 + x", "").guard == "f < 2 + x");
  CHECK(texts_of("((x)) < ((1))", "").guard == "x < 1");
  CHECK(texts_of("x < - -y", "").guard == "x < -(-y)");
}

TEST_CASE("actions") {
  for (const char* action :
       {"x = 1; y = x + 1;", "if (x < 1) then y = 1; else if (b) then y = 2; fi fi x = 3;", "s = \"\\u0001\";"}) {
    const Texts first = texts_of("b", action);
    CHECK(first.action == action);
    CHECK(texts_of("b", first.action).system == first.system);
  }
}

TEST_CASE("define trees") {
  const auto define = [](const std::string& text) {
    test::Instantiated t(
        "package t\nport type P()\nconnector type C(P a, P b, P c, P d) define " + text +
        " end\natom type A()\n  export port P p()\n  place S\n  initial to S\n  on p from S to S\nend\n"
        "compound type R()\n  component A a(), b(), c(), d()\n  connector C k(a.p, b.p, c.p, d.p)\nend\nend\n");
    REQUIRE(t.codes().empty());
    return graph::define_of(t.system->connector_types[ConnectorTypeId(std::size_t{0})]);
  };
  for (const char* text : {"a b c d", "a' b c' d", "(a b)' c d", "a' (b' (c d))", "(a (b' c)')' d"})
    CHECK(define(text) == text);
}
