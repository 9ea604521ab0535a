// A comment at every blank of a file: none is lost, none is printed twice, printing again changes nothing.
#include <catch2/catch.hpp>

#include "tests/unit/parse/parsed.hpp"

using namespace bip;
using test::Parsed;

namespace {

int count(const std::string& text, const std::string& what) {
  int n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

void check_everywhere(const std::string& text) {
  for (std::size_t i = 0; i <= text.size(); ++i) {
    if (i < text.size() && text[i] != ' ' && text[i] != '\n') continue;
    for (const std::string comment : {" /* zz */ ", " // zz\n", "\n// zz\n"}) {
      const std::string with = text.substr(0, i) + comment + text.substr(i);
      INFO(with);
      Parsed first(with);
      REQUIRE(first.messages().empty());
      const std::string once = first.printed();
      INFO(once);
      CHECK(count(once, "zz") == 1);
      Parsed second(once);
      REQUIRE(second.messages().empty());
      CHECK(second.printed() == once);
      CHECK(second.shape() == first.shape());
    }
  }
}

}  // namespace

TEST_CASE("comments anywhere in BIP2") {
  check_everywhere(
      "package p\nport type P(int d)\nconnector type C(P a, P b)\ndata int z\nexport port P o(z)\ndefine a' b\non a b "
      "provided (a.d < 3) up { z = 1; } down { b.d = a.d; a.d = 2; }\nend\n"
      "atom type N(int k)\ndata int x = 1, y\nexport port P p(x)\nplace A, B\ninitial to A do { x = 1; }\non p from A "
      "to B provided (x > 0) do { if (x < 1) then y = 1; else y = 2; fi x = 2; }\nend\n"
      "compound type R()\ncomponent N a(1), b(2)\nconnector C c(a.p, b.p)\nfor i in 0..2 { component N d[i](1) "
      "component N e[i](2) }\npriority q c:* < *:*\nexport port c.o as o\nend\nend");
}

TEST_CASE("comments anywhere in the paper's notation") {
  check_everywhere(
      "component A\nport in, out\ndata int x\nbehavior initial to s do x <- 1\nstate s\non in provided x < 1 do x <- 2 "
      "to t\nstate t\non out do { x <- 1; x <- 2; } to s\nend\nend\n"
      "component B\ncontains A a, b(x = 1)\nconnector c(a.in, b.out)\ndefine [a.in', b.out]\non a.in, b.out provided "
      "a.x < 1 do { a.x <- 1; }\non a.in do {}\npriority p c < d\nend");
}
