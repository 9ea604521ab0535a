// What is accepted, in both notations, and what the tree says about it.
#include <catch2/catch.hpp>

#include "tests/unit/parse/parsed.hpp"

using namespace bip;
using namespace bip::syntax;
using test::in_atom;
using test::Parsed;

TEST_CASE("a package with one of everything") {
  Parsed p(R"(@cpp(include="a.h,b.h", src="ext/a.cpp")
package a.b.c
  use std.ports
  use x
  const data int n = 3, m = n + 1
  data const float pi = 3.14
  extern data type List refine Base, other.Top as "std::list<int>"
  extern function printf(string, int)
  extern function const int size(const List l)
  extern operator bool == (const List a, const List b)
  function int twice(int v) = 2 * v
  port type IntPort(int d, const bool b)
  connector type Sum(IntPort a, IntPort b, IntPort c)
    data int total = 0
    export port IntPort out(total)
    define (a b)' c
    @SuppressWarning(missingup)
    on a b provided (a.d > 0) up { total = a.d + b.d; } down { a.d = total; }
    on a b c
  end
end)");
  REQUIRE(p.codes().empty());
  CHECK(p.syntax->package->name.parts.size() == 3);
  CHECK(p.syntax->package->uses.size() == 2);
  CHECK(p.syntax->package->annotations[0].args[0].value == "a.h,b.h");
  CHECK(p.decl(0).data[0].vars.size() == 2);
  CHECK(p.decl(2).cpp_name == "std::list<int>");
  CHECK(p.decl(2).refines.size() == 2);
  CHECK(p.decl(4).result.is_const);
  CHECK(p.decl(5).op.text == "==");
  CHECK(p.decl(6).body != nullptr);
  const ConnectorBody& sum = *p.decl(8).connector;
  CHECK(sum.define->children.size() == 2);
  CHECK(sum.define->children[0]->trigger);
  CHECK(sum.clauses[0].annotations.size() == 1);
  CHECK(sum.exported.vars[0].text == "total");
}

TEST_CASE("an atom with time, external ports and rules") {
  Parsed p(R"(package p
  atom type T(int k)
    export data int shown = 1
    clock t, u unit millisecond
    clock v
    export port P a(shown), b(shown) as e
    port P hidden()
    extern port P ext(shown) as "Reader" ignore
    place A, B
    initial to A, B do { t = 0; } resume (t > 1)
    on a from A, B to B, A provided (t <= 5) eager do { t' = 2.0; } resume
    internal from B to A
    priority one a < *
    priority two * < b provided (shown > 1)
    invariant i at A, B provided (t <= 5)
    invariant j from A provided (t - u < 3)
    invariant k provided (true)
  end
end)");
  REQUIRE(p.codes().empty());
  const Decl& d = p.decl(0);
  CHECK(d.ports[0].merged_as.text == "e");
  CHECK(d.ports[2].extern_class == "Reader");
  CHECK(d.ports[2].extern_policy.text == "ignore");
  CHECK(d.clocks[0].unit.text == "millisecond");
  CHECK(d.initial.resumes);
  CHECK(d.transitions[0].urgency.text == "eager");
  CHECK(d.transitions[0].from.size() == 2);
  CHECK(d.transitions[0].resumes);
  CHECK(d.transitions[0].resume == nullptr);
  CHECK(d.atom_priorities[0].high.text == "*");
  CHECK(d.invariants[1].scope == InvariantScope::From);
}

TEST_CASE("a compound with arrays, loops, priorities and exports") {
  Parsed p(R"(package p
  compound type Ring(int n)
    component Node a[n](1, x = 2), b()
    connector Sync s(a[0].in, a[*].out), t(b.p, s.e)
    for i in 0..n connector Pass c[i](a[i].out, a[(i+1) % n].in)
    for i in 0..n-1 { component Node d[i]() connector mix(d[i].p, b.p) define [d[i].p', b.p] }
    priority one s:a.p,b.q < t:*
    priority two *:* < s:* provided (a.x > 1)
    export port a.p, b.p as out
    export data b.x as x
  end
end)");
  REQUIRE(p.codes().empty());
  const Decl& d = p.decl(0);
  REQUIRE(d.items.size() == 6);
  CHECK(d.items[0]->args[1].name.text == "x");
  CHECK(d.items[2]->ports[1].parts[0].star);
  CHECK(d.items[4]->kind == ItemKind::For);
  CHECK(d.items[5]->items[1]->inline_body != nullptr);
  CHECK(d.priorities[0].low.ports.size() == 2);
  CHECK(d.priorities[1].low.any_connector);
  CHECK(d.exports[0].targets.size() == 2);
  CHECK(d.exports[1].is_data);
}

TEST_CASE("components of the paper's notation") {
  Parsed p(
      "component Filter(int k)\n"
      "  port in, out\n"
      "  port Msg report(x)\n"
      "  data int x, y = 1\n"
      "  behavior initial to empty do x <- 0\n"
      "    state empty\n"
      "      on in provided 0 < x \xE2\x88\xA7 x = y do y \xE2\x86\x90 x + 1 to full\n"
      "      internal to empty\n"
      "    state full\n"
      "      on out to empty\n"
      "  end\n"
      "end\n"
      "component Root\n"
      "  contains Filter f, g(k = 3), h[4]\n"
      "  connector pair(f.out, g.in)\n"
      "    define [f.out\xE2\x80\x99 g.in]\n"
      "    on f.out, g.in provided \xC2\xAC(f.bank.id = \"Marlin\") do { g.in.v <- NOT-SO-FAST }\n"
      "    on f.out do {}\n"
      "  connector sum([f.tick, g.tick]) export port Port tick define [f.tick, g.tick]\xE2\x80\xB2, h[*].tick\n"
      "  connector bare(f.in)\n"
      "  priority low pair < sum provided f.x > 1\n"
      "  export port tick as t\n"
      "end\n");
  REQUIRE(p.messages().empty());
  const Decl& filter = p.decl(0);
  CHECK(filter.kind == DeclKind::AtomType);
  CHECK(filter.notation == Notation::Paper);
  CHECK(filter.ports[0].role == PortRole::Exported);
  CHECK_FALSE(filter.ports[0].type.is_written());
  CHECK(filter.places.size() == 2);
  CHECK(filter.transitions[0].from[0].text == "empty");
  CHECK(filter.transitions[0].to[0].text == "full");
  const Decl& root = p.decl(1);
  CHECK(root.kind == DeclKind::CompoundType);
  CHECK(root.items.size() == 6);
  CHECK(root.items[3]->inline_body->define->children[0]->trigger);
  CHECK(root.items[3]->inline_body->clauses[0].action.stmts[0]->value->kind == ExprKind::Report);
  CHECK(root.items[4]->inline_body->exported.name.text == "tick");
  CHECK(root.items[4]->ports.size() == 2);
  CHECK(root.items[5]->inline_body->define == nullptr);
  CHECK(root.exports[0].name.text == "t");
}

TEST_CASE("if chains close with one fi or with one each") {
  const std::string nested = Parsed(in_atom("internal from A to B do { if (x < 1) then y = 1; else if (x < 2) then y = "
                                            "2; else y = 3; fi fi x = 0; }"))
                                 .shape();
  const std::string chain =
      Parsed(
          in_atom(
              "internal from A to B do { if (x < 1) then y = 1; else if (x < 2) then y = 2; else y = 3; fi x = 0; }"))
          .shape();
  CHECK(nested == chain);
  CHECK_THAT(chain, Catch::Contains("Else\n") && Catch::Contains("Assign x = 0"));
  CHECK(Parsed(
            in_atom(
                "internal from A to B do { if (x < 1) then if (y < 1) then y = 1; else if (y < 2) then y = 2; fi fi }"))
            .codes()
            .empty());
  CHECK(Parsed(in_atom("internal from A to B do { if (x < 1) then if (y < 1) then y = 1; else if (y < 2) then y = 2; "
                       "fi fi fi }"))
            .codes()
            .empty());
}

TEST_CASE("parts of a transition stand in any order") {
  const std::string a = Parsed(in_atom("on p from A to B provided (x > 1) do { x = 1; }")).shape();
  const std::string b = Parsed(in_atom("on p provided (x > 1) to B do { x = 1; } from A")).shape();
  CHECK(a == b);
}
