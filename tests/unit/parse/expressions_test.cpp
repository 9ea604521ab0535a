// Precedence, chains, depth, and what may not stand in an expression.
#include <catch2/catch.hpp>

#include "tests/unit/parse/parsed.hpp"

using namespace bip;
using test::in_atom;
using test::Parsed;

namespace {
std::string value(const std::string& expr) {
  Parsed p("package p\nconst data int x = " + expr + "\nend");
  if (!p.codes().empty()) return p.codes();
  const std::string shape = p.shape();
  const std::size_t at = shape.find("x=") + 2;
  return shape.substr(at, shape.find('\n', at) - at);
}
std::string repeat(const std::string& s, int n) {
  std::string out;
  for (int i = 0; i < n; ++i) out += s;
  return out;
}
}  // namespace

TEST_CASE("precedence is C's") {
  CHECK(value("a || b && c | d ^ e & f == g < h + i * -j") ==
        "(a || (b && (c | (d ^ (e & (f == (g < (h + (i * (-j))))))))))");
  CHECK(value("a - b - c") == "((a - b) - c)");
  CHECK(value("a % b / c * d") == "(((a % b) / c) * d)");
  CHECK(value("!a && ~b == c") == "((!a) && ((~b) == c))");
  CHECK(value("(a + b) * f(x, t[i].v)") == "((a + b) * f(x, t[i].v))");
}

TEST_CASE("the paper's operators mean the same") {
  CHECK(value("\xC2\xAC"
              "a \xE2\x88\xA7 b \xE2\x88\xA8 c \xE2\x89\xA4 d") == "(((!a) && b) || (c <= d))");
  Parsed p(in_atom("internal from A to B provided (not x == 1 and not (y \xE2\x89\xA0 2))"));
  CHECK_THAT(p.shape(), Catch::Contains("(((!x) == 1) && (!(y != 2)))"));
}

TEST_CASE("comparisons do not chain and = does not compare in BIP2") {
  CHECK(value("a < b < c") == "B0010");
  CHECK(value("(a < b) == c") == "((a < b) == c)");
  CHECK(value("a = b") == "B0011");
  CHECK(Parsed(in_atom("internal from A to B provided (x = 1)")).codes() == "B0011");
  CHECK(Parsed("component C data int x behavior initial to s state s internal provided x = 1 to s end end")
            .codes()
            .empty());
}

TEST_CASE("x<-1 is a comparison in a guard and an assignment as a statement") {
  Parsed p(in_atom("internal from A to B provided (x<-1) do { x <- 1; y := 2; }"));
  CHECK(p.codes().empty());
  CHECK_THAT(p.shape(),
             Catch::Contains("(x < (-1))") && Catch::Contains("Assign x = 1") && Catch::Contains("Assign y = 2"));
  CHECK(Parsed(in_atom("internal from A to B do { x < -1; }")).codes() == "B0001");
}

TEST_CASE("depth has a limit and no length overflows the stack") {
  CHECK(value(repeat("(", 400) + "1" + repeat(")", 400)) == "1");
  CHECK(value(repeat("(", 100000) + "1" + repeat(")", 100000)) == "B0008");
  CHECK(value(repeat("-", 100000) + "1") == "B0008");
  CHECK(value(repeat("a + ", 100000) + "1") == "B0008");
  CHECK(value(repeat("a[", 100000) + "1" + repeat("]", 100000)) == "B0008");
  CHECK(Parsed(in_atom("internal from A to B do {" + repeat("if (x < 1) then ", 100000))).codes() == "B0008");
  CHECK(
      Parsed("package p compound type C() " + repeat("for i in 0..2 ", 100000) + " component T t() end end").codes() ==
      "B0008");
  CHECK(Parsed("package p connector type C(P a) define " + repeat("(", 100000) + "a end end").codes() == "B0008");
}

TEST_CASE("a root is a type with arguments") {
  SourceMap sources;
  Diagnostics diags;
  const auto root = parse::parse_root(sources, "a.b.Root(1, 2.5, true, \"s\", -3)", diags);
  REQUIRE(root);
  CHECK(root->type == "a.b.Root");
  CHECK(root->args.size() == 5);
  CHECK(parse::parse_root(sources, "Root", diags)->args.empty());
  CHECK_FALSE(diags.has_errors());
  CHECK_FALSE(parse::parse_root(sources, "1 + 2", diags));
  CHECK(diags.has_errors());
}
