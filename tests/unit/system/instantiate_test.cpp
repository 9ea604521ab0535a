// Unfolding: names, order, arguments and bindings of what a compound stands for, computed by hand.
#include <catch2/catch.hpp>

#include "compiler/system/bsys.hpp"
#include "tests/unit/system/instantiated.hpp"

namespace {

using bip::test::Instantiated;
using bip::test::with_types;

std::string shape(const std::string& compounds, const std::string& root = {}) {
  const Instantiated made(with_types(compounds), root);
  if (made.system) CHECK(bip::system::validate(*made.system).empty());
  return made.shape();
}

TEST_CASE("an array, its arguments and a loop of connectors") {
  REQUIRE(shape("compound type R(int n) component A a[n](n * 2) for i in 0..n - 1 { connector Two k[i](a[i].p, a[i + "
                "1].q) } end",
                "R(3)") ==
          "ROOT.a[0]: A(6)\nROOT.a[1]: A(6)\nROOT.a[2]: A(6)\n"
          "ROOT.k[0]: (ROOT.a[0].p) (ROOT.a[1].q)\nROOT.k[1]: (ROOT.a[1].p) (ROOT.a[2].q)\n");
}

TEST_CASE("a loop excludes its upper end, and nests") {
  REQUIRE(shape("compound type R() component A a[2](1) for i in 0..2 { for j in i..2 { connector Two k[i * 2 + "
                "j](a[i].p, a[1 - i].q) } } end") ==
          "ROOT.a[0]: A(1)\nROOT.a[1]: A(1)\n"
          "ROOT.k[0]: (ROOT.a[0].p) (ROOT.a[1].q)\nROOT.k[1]: (ROOT.a[0].p) (ROOT.a[1].q)\nROOT.k[3]: (ROOT.a[1].p) "
          "(ROOT.a[0].q)\n");
}

TEST_CASE("an element of its own in a loop") {
  REQUIRE(shape("compound type R(int n) for i in 0..n { component A a[i](i * i) } connector One k(a[1].p) end",
                "R(3)") == "ROOT.a[0]: A(0)\nROOT.a[1]: A(1)\nROOT.a[2]: A(4)\nROOT.k: (ROOT.a[1].p)\n");
}

TEST_CASE("a star stands for all elements") {
  REQUIRE(shape("compound type R(int n) component A a(0), b[n](1) connector k(a.p, b[*].q) define [a.p, b[*].q] end",
                "R(3)") ==
          "ROOT.a: A(0)\nROOT.b[0]: A(1)\nROOT.b[1]: A(1)\nROOT.b[2]: A(1)\n"
          "ROOT.k: (ROOT.a.p) (ROOT.b[0].q) (ROOT.b[1].q) (ROOT.b[2].q)\n");
}

TEST_CASE("compounds in compounds, depth first, with what they export") {
  REQUIRE(shape("compound type Inner(int k) component A a(k), b(k + 1) export port a.p as p end "
                "compound type Middle(int k) component Inner l(k), r(k * 10) export port r.p as p end "
                "compound type R() component Middle m(1) component A c(7) connector Two k(m.p, c.q) end") ==
          "ROOT.m.l.a: A(1)\nROOT.m.l.b: A(2)\nROOT.m.r.a: A(10)\nROOT.m.r.b: A(11)\nROOT.c: A(7)\nROOT.k: "
          "(ROOT.m.r.a.p) (ROOT.c.q)\n");
}

TEST_CASE("a connector comes after those it binds, whatever the text says; who is bound is marked") {
  REQUIRE(shape("compound type R() component A a(0), b(1), c(2) connector Two k(j.x, c.p) connector Joined j(a.p, "
                "b.p), free(a.q, b.q) end") ==
          "ROOT.a: A(0)\nROOT.b: A(1)\nROOT.c: A(2)\n"
          "ROOT.j: (ROOT.a.p) (ROOT.b.p) bound\nROOT.k: (ROOT.j) (ROOT.c.p)\nROOT.free: (ROOT.a.q) (ROOT.b.q)\n");
}

TEST_CASE("through a compound's port only maximal interactions are seen, inside all") {
  REQUIRE(shape("compound type Inner() component A a(0), b(1), c(2) connector Maybe j(a.p, b.p) connector Two "
                "inside(j.x, c.p) export port j.x as e end "
                "compound type R() component Inner i() component A d(3) connector Two k(i.e, d.p) end") ==
          "ROOT.i.a: A(0)\nROOT.i.b: A(1)\nROOT.i.c: A(2)\nROOT.d: A(3)\n"
          "ROOT.i.j: (ROOT.i.a.p) (ROOT.i.b.p) bound\nROOT.i.inside: (ROOT.i.j) (ROOT.i.c.p)\nROOT.k: (max ROOT.i.j) "
          "(ROOT.d.p)\n");
}

TEST_CASE("what only instances show is said") {
  CHECK(shape("compound type R(int n) component A a[n](0) connector One k(a[n].p) end", "R(2)") == "B4014");
  CHECK(shape("compound type R(int n) component A a[n](0) end", "R(-1)") == "B4016");
  CHECK(shape("compound type R(int n) component A a[n](1 / n) end", "R(0)") == "B4008");
  CHECK(shape("compound type R(int n) component A a[2](0) for i in 0..2 { connector One k[n](a[i].p) } end", "R(0)") ==
        "B4015");
  CHECK(shape("compound type R() component A a[2000001](0) end") == "B4006");
}

TEST_CASE("compounds that double are counted before they are made") {
  std::string chain = "compound type C0() component A a(0), b[0](1) end\n";
  for (int i = 1; i < 64; ++i) {
    const std::string inner = "C" + std::to_string(i - 1);
    chain += "compound type C" + std::to_string(i) + "() component " + inner + (i % 2 == 0 ? " c(), d()" : " c[2]()") +
             " end\n";
  }
  CHECK(shape(chain, "C20()") == "B4006");
  CHECK(shape(chain, "C63()") == "B4006");
  CHECK(shape(chain, "C1()") == "ROOT.c[0].a: A(0)\nROOT.c[1].a: A(0)\n");
}

TEST_CASE("an array without elements") {
  REQUIRE(shape("compound type R(int n) component A a[n](0), b(1) for i in 0..n { connector One k[i](a[i].p) } end",
                "R(0)") == "ROOT.b: A(1)\n");
  REQUIRE(shape("compound type R(int n) component A a[n](0), b(1) connector k(b.p, a[*].p) define [b.p', a[*].p] end",
                "R(0)") == "ROOT.b: A(1)\nROOT.k: (ROOT.b.p)\n");
}

}  // namespace
