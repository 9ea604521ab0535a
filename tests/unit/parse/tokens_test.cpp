// Words whose meaning depends on their neighbours, numbers next to dots, comments, strings.
#include <catch2/catch.hpp>

#include "compiler/parse/token_list.hpp"
#include "compiler/parse/unescape.hpp"
#include "tests/unit/parse/parsed.hpp"

using namespace bip;
using test::in_atom;
using test::Parsed;

namespace {
std::string tokens(const std::string& text) {
  SourceMap sources;
  return parse::dump_tokens(sources, sources.add("t", text));
}
}  // namespace

TEST_CASE("a range is not a float") {
  CHECK(tokens("0..n") == "1:1  INT  0\n1:2  DOTDOT  ..\n1:4  ID  n\n");
  CHECK(tokens("1. .5 1.5e-2 1e3") == "1:1  FLOAT  1.\n1:4  FLOAT  .5\n1:7  FLOAT  1.5e-2\n1:14  FLOAT  1e3\n");
}

TEST_CASE("a dashed word is a report in a component and a subtraction elsewhere") {
  CHECK_THAT(tokens("component A data int x behavior initial to s do x <- TOO-FAST-1"),
             Catch::Contains("STRAY") || Catch::Contains("REPORT  TOO-FAST"));
  CHECK_THAT(tokens("atom type T() x = A-B"),
             Catch::Contains("ID  A\n") && Catch::Contains("MINUS  -\n") && Catch::Contains("ID  B\n"));
  CHECK_THAT(tokens("X-Y_Z"), Catch::Contains("ID  Y_Z\n"));
}

TEST_CASE("positions are bytes after signs of several bytes") {
  CHECK(tokens("\xE2\x88\xA7 x") == "1:1  ANDAND  \xE2\x88\xA7\n1:5  ID  x\n");
  CHECK(tokens("\xEF\xBB\xBFx") == "1:4  ID  x\n");
}

TEST_CASE("late words are names in BIP2") {
  Parsed p(
      in_atom("data int clock, unit, state, behavior, contains, lazy, eager, resume, at, error, remember, ignore, "
              "invariant, in, for, sync, async, hour\n"
              "port Port behavior(state), contains(in)\n"
              "on behavior from A to B provided (state < in && at > 0) do { state = in; clock = unit; }\n"
              "on contains from B to A do { for = lazy; resume = eager; }"));
  CHECK(p.codes().empty());
  CHECK(p.decl(0).transitions.size() == 2);
  Parsed q(
      "package p\nconnector type C(P state, P resume, P sync)\ndefine state resume' sync\non state resume\nend\nend");
  CHECK(q.codes().empty());
  CHECK_THAT(q.shape(), Catch::Contains("Define (state resume' sync)"));
}

TEST_CASE("resume ends a define unless it is marked") {
  Parsed p("package p\nconnector type C(P a, P b)\ndefine a b resume async\nend\nend");
  CHECK_THAT(p.shape(), Catch::Contains("Define (a b) resume async"));
}

TEST_CASE("a comment may end the file without a line break") {
  Parsed p("package p port type P() end // last");
  CHECK(p.codes().empty());
  REQUIRE(p.syntax->comments.size() == 1);
}

TEST_CASE("lexical errors are found and the rest is read") {
  CHECK(Parsed("package p\nport type P()\n/* open").codes() == "B0003");
  CHECK(Parsed("package p\nconst data string s = \"abc\nport type P()\nend").codes() == "B0004");
  CHECK(Parsed("package p\nport type P$()\nend").codes() == "B0002");
  CHECK(Parsed("package p \xFF end").codes() == "B0002");
  CHECK(Parsed("").codes() == "B0009");
}

TEST_CASE("escapes") {
  std::string out;
  CHECK(parse::unescape("a\\n\\t\\\"\\\\\\u00e9\\101\\0", out).empty());
  CHECK(out == std::string("a\n\t\"\\\xC3\xA9"
                           "A\0",
                           9));
  out.clear();
  const auto bad = parse::unescape("x\\q", out);
  REQUIRE(bad.size() == 1);
  CHECK(bad[0].begin == 1);
  CHECK(parse::string_body("\"a\\\"") == "a\\\"");
}
