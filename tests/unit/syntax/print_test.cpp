// The house style, comments, and the two laws of a formatter: printing again changes nothing, and the tree stays the
// same.
#include <catch2/catch.hpp>

#include "tests/unit/parse/parsed.hpp"

using namespace bip;
using test::in_atom;
using test::Parsed;

namespace {
void check_laws(const std::string& text) {
  INFO(text);
  Parsed first(text);
  REQUIRE(first.messages().empty());
  const std::string once = first.printed();
  INFO(once);
  Parsed second(once);
  REQUIRE(second.messages().empty());
  CHECK(second.printed() == once);
  CHECK(second.shape() == first.shape());
}
std::string printed(const std::string& text) {
  check_laws(text);
  return Parsed(text).printed();
}
}  // namespace

TEST_CASE("BIP2 in house style") {
  CHECK(printed("package p port type   P( int d )\nconnector type C(P a,P b) define a'b on a b "
                "provided(a.d<3)down{b.d=a.d;} end\n"
                "atom type N() data int x=1 export port P p(x) place A,B initial to A\n on p from A to B provided "
                "(((x>0))) do {x=x+1;} end end") ==
        "package p\n"
        "  port type P(int d)\n"
        "\n"
        "  connector type C(P a, P b)\n"
        "    define a' b\n"
        "    on a b provided (a.d < 3) down { b.d = a.d; }\n"
        "  end\n"
        "\n"
        "  atom type N()\n"
        "    data int x = 1\n"
        "    export port P p(x)\n"
        "    place A, B\n"
        "    initial to A\n"
        "    on p from A to B provided (x > 0) do { x = x + 1; }\n"
        "  end\n"
        "end\n");
}

TEST_CASE("the paper's notation stays the paper's") {
  CHECK(printed("component R port in,out data int x,y behavior initial to e state e on in provided (0<x) do { y := "
                "f(x); } to e on out do {x=1;y=2;} to e end end") ==
        "component R\n"
        "  port in, out\n"
        "  data int x, y\n"
        "  behavior initial to e\n"
        "    state e\n"
        "      on in provided 0 < x do y <- f(x) to e\n"
        "      on out do { x <- 1; y <- 2; } to e\n"
        "  end\n"
        "end\n");
}

TEST_CASE("an if takes a line a statement") {
  CHECK_THAT(printed(in_atom("on p from A to B do { if (x<1) then x=1; else if (x<2) then x=2; fi fi y=1; }")),
             Catch::Contains("    on p from A to B do {\n"
                             "      if (x < 1) then\n"
                             "        x = 1;\n"
                             "      else if (x < 2) then\n"
                             "        x = 2;\n"
                             "      fi fi\n"
                             "      y = 1;\n"
                             "    }\n"));
  CHECK_THAT(printed(in_atom("on p from A to B do { if (x<1) then x=1; else if (x<2) then x=2; fi y=1; }")),
             Catch::Contains("        x = 2;\n"
                             "      fi\n"
                             "      y = 1;\n"));
}

TEST_CASE("comments stay with what they are about") {
  const std::string text = printed(
      "// file\n\npackage p // package\n  // port\n  port type P() // after\n\n\n\n  /* atom\n     * two\n   */\n  "
      "atom type N() // header\n"
      "    place A /* inside */ , B // places\n    initial to A\n    // before on\n    on p from A to B do {\n  // in "
      "block\n x = 1; // x\n // last\n }\n    // end\n  end\n// tail\nend // done\n// eof");
  CHECK(text ==
        "// file\n\npackage p  // package\n  // port\n  port type P()  // after\n\n  /* atom\n   * two\n   */\n  atom "
        "type N()  // header\n"
        "    /* inside */\n    place A, B  // places\n    initial to A\n    // before on\n    on p from A to B do {\n  "
        "    // in block\n      x = 1;  // x\n"
        "      // last\n    }\n    // end\n  end\n  // tail\nend  // done\n// eof\n");
}

TEST_CASE("printing again changes nothing, in either notation") {
  check_laws(
      "package a.b\nuse c\n@x(k=1,s=\"a b\") const data string s = \"q\\\"\\u00e9\\n\", t=\"\"\nextern function f(int, "
      "const x.T y)\nextern data type T as \"a\\\\b\"\nfunction int g(int v)=(v+1)\nend");
  check_laws(in_atom(
      "clock c unit hour\nextern port P q(x) as \"K\" remember\ninternal provided (c'>1 && -(-x) == +y) from A,B to A "
      "resume (x<1) lazy do {f(x); c'=2.0;}\ninvariant i at A,B provided (c<1)\npriority z * < q provided (x==1)"));
  check_laws(
      "package p compound type C(int n) component T a[n](1,x=2),b() for i in 0..n {component T c[i]() connector S "
      "d[i](c[i].p)} for j in 0..2 for k in j..3 connector S e[k](b.p)\n"
      "connector mix(a[0].p,b.q) define (a[0].p b.q)' export port P out on a[0].p, b.q provided a[0].p.x = 1 do "
      "{b.q.x=1;}\npriority r mix:a.p,b.q<*:* export port a.p,b.q as z end end");
  check_laws(
      "component A port P p(x), q data int x behavior initial to s do {x=1;x=2;} state s internal provided x "
      "\xE2\x89\xA4 1 \xE2\x88\xA7 not (x = 2) to t state t on p eager to s end invariant i at s provided x<1 end\n"
      "component B contains A a, b(x=1) connector c([a.p,b.p]) connector d(a.p,b.p) define [a.p,[b.p]']' on a.p up "
      "{x=1;} down {} priority k c<d end");
  check_laws("component A port p data int x place s, t initial to s on p from t to s on p from s to t end");
}
