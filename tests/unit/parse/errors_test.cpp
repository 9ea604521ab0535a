// Messages, recovery, and the promise that the parser generator never speaks.
#include <catch2/catch.hpp>

#include "tests/unit/parse/parsed.hpp"

using namespace bip;
using Catch::Contains;
using test::in_atom;
using test::Parsed;

TEST_CASE("a message says what was read, what may follow and what was found") {
  CHECK_THAT(Parsed(in_atom("on p to B")).messages(),
             Contains("expected `from` after port `p` in a transition of atom type `N`, found `to`"));
  CHECK_THAT(Parsed(in_atom("on p from A")).messages(),
             Contains("expected `to` after `from A` in a transition of atom type `N`, found the next item"));
  CHECK_THAT(Parsed(in_atom("on p from to B")).messages(),
             Contains("expected a name after `from` in a transition of atom type `N`, found `to`"));
  Parsed misspelled(in_atom("on p from A prvided (x < 3) to B"));
  CHECK_THAT(misspelled.messages(), Contains("found `prvided`"));
  REQUIRE(misspelled.diags.sorted().size() == 1);
  REQUIRE(misspelled.diags.sorted()[0]->helps.size() == 1);
  CHECK(misspelled.diags.sorted()[0]->helps[0].with == "provided");
}

TEST_CASE("each broken item is one error and the others are read") {
  Parsed p(
      in_atom("on a from A\non b fro A to B\non c from A to B\non d from A to B provided (x < do { x = 1; }\non e from "
              "B to A"));
  CHECK(p.codes() == "B0001 B0001 B0001");
  REQUIRE(p.syntax);
  CHECK(p.decl(0).transitions.size() == 2);
}

TEST_CASE("a broken declaration leaves the next one whole") {
  Parsed p("package p\natom type (\nplace A\nend\nport type P()\nprot type Q()\nport type R()\nend");
  CHECK(p.codes() == "B0001 B0001");
  CHECK(p.syntax->package->decls.size() == 2);
}

TEST_CASE("a missing end is told at what it would close") {
  Parsed p("package p\natom type N()\nplace A\ninitial to A\nport type P()\nend");
  CHECK(p.codes() == "B0006");
  CHECK_THAT(p.messages(), Contains("atom type `N` has no `end`"));
  CHECK(p.syntax->package->decls.size() == 2);
  CHECK(Parsed("component C port p behavior initial to s state s on p to s end").codes() == "B0006");
}

TEST_CASE("a missing bracket is told with its opener") {
  Parsed p(in_atom("on a from A to B provided (x < 3 do { x = 1; }\non b from B to A do { x = 1;\non c from A to B"));
  CHECK(p.codes() == "B0007 B0007");
  CHECK(p.diags.sorted()[0]->labels.size() == 1);
  CHECK(p.decl(0).transitions.size() >= 2);
}

TEST_CASE("statements need a semicolon between them") {
  CHECK(Parsed(in_atom("on a from A to B do { x = 1 y = 2; }")).codes() == "B0012");
  CHECK(Parsed(in_atom("on a from A to B do { x = 1; y = 2 }")).codes().empty());
}

TEST_CASE("what does not belong is told by name") {
  CHECK(Parsed(in_atom("component T t()")).codes() == "B0016");
  CHECK(Parsed("package p compound type C() component T t() on p from A to B end end").codes() == "B0016");
  CHECK(Parsed(in_atom("on a from A from B to A")).codes() == "B0013");
  CHECK(Parsed("package p connector type C(P a) end end").codes() == "B0014");
  CHECK(Parsed("package p atom type N() end end").codes() == "B0014");
  CHECK(Parsed("package p port type P() end package q end").codes() == "B0017");
  CHECK(Parsed("package p end port type P()").codes() == "B0018");
  CHECK(Parsed(in_atom("clock c unit fortnight")).codes() == "B0021");
}

TEST_CASE("no cut of a file makes the parser crash or quote its generator") {
  const std::string whole = in_atom(
      "clock c unit second\nexport port P p(x), q() as e\non p from A to B provided (x < 3 && !(y == f(2))) eager do { "
      "if (x < 1) then x = 1; else y = -2; fi }\n"
      "invariant i at A provided (c <= 5)\npriority z p < *");
  for (std::size_t n = 0; n <= whole.size(); ++n) {
    for (const std::string& text : {whole.substr(0, n), whole.substr(n), whole.substr(0, n) + " ) " + whole.substr(n),
                                    whole.substr(0, n) + " end " + whole.substr(n)}) {
      const std::string said = Parsed(text).messages();
      for (const char* phrase :
           {"no viable alternative", "mismatched input", "extraneous input", "missing '", "<missing", "another word"}) {
        INFO(text);
        CHECK_THAT(said, !Contains(phrase));
      }
    }
  }
}
