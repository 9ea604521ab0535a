// A sound file is read in pieces, any other as a whole: both ways give the same tree.
#include <catch2/catch.hpp>

#include "tests/unit/parse/parsed.hpp"

namespace {

using bip::test::Parsed;

constexpr const char* kFile = R"(@cpp(include="a.h") package p.q
use std.ports use other
port type P(int v)
@SuppressWarning(x) connector type K(P a, P b) define a' [b] on a b provided (a.v < b.v) up {} down { a.v = b.v; } end
const data int n = 3
function int f(int x) = x * 2 + 1
extern function int g(int)
atom type A(int k)
  data int v = 0
  @mark export port P p(v)
  port P i(v)
  place S, T
  initial to S do { v = k; }
  on p from S to T provided (v > 0 || k == 1) do { if (v > 1) then v = v - 1; else v = 0; fi }
  internal from T to S
  priority r i < p
end
compound type C(int m, bool b)
  component A a(1), b[m](m * 2)
  @mark connector K k(a.p, b[0].p)
  connector j(a.p, b[*].p) define [a.p, b[*].p]'
  for x in 0..m - 1 { component A z[x](x) connector K l[x](z[x].p, b[x].p) }
  priority high k:a.p, b.p < j:*
  priority all *:* < k:*
  export port k.x, j.x as e
end
@mark compound type D() component C c(3, true) end
component Paper(int a)
  port go
  behavior initial to S do a = 1 state S on go provided a = 2 do a := a + 1 to S end
end
)";

TEST_CASE("a file in pieces and the same file as a whole") {
  const Parsed pieces(std::string(kFile) + "end\n");
  REQUIRE(pieces.messages().empty());
  // The declaration that cannot be read makes the reader start again with the whole.
  const Parsed whole(std::string(kFile) + "atom atom\nend\n");
  REQUIRE_FALSE(whole.messages().empty());
  REQUIRE(whole.syntax.has_value());
  REQUIRE(pieces.syntax->package->decls.size() == 9);
  REQUIRE(whole.shape() == pieces.shape());
}

TEST_CASE("a file without a package, and declarations with annotations first") {
  const Parsed bare("@mark port type P()\ncompound type R() end\n");
  REQUIRE(bare.codes() == "B0014");
  const Parsed sound(
      "@mark port type P()\natom type A() place S initial to S end\ncompound type R() component A a() end");
  REQUIRE(sound.messages().empty());
  REQUIRE(sound.syntax->package->decls.size() == 3);
  REQUIRE(sound.decl(0).annotations.size() == 1);
}

TEST_CASE("what is left of a file in pieces after its end is seen") {
  REQUIRE(Parsed("package p port type P() end end").codes() == "B0001");
  REQUIRE(Parsed("package p port type P() compound type").codes().substr(0, 5) == "B0001");
  REQUIRE(Parsed("package p port type P() end package q end").codes() == "B0017");
}

}  // namespace
