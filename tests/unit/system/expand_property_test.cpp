#include "compiler/system/expand_property.hpp"

#include <catch2/catch.hpp>

using bip::Type;
using bip::Value;
using bip::system::expand_property;

namespace {

const std::map<std::string, Value, std::less<>> kConstants = {
    {"n", {Type::Int, 3, 0}},      {"i", {Type::Int, 2, 0}},        {"low", {Type::Int, -4, 0}},
    {"open", {Type::Bool, 1, 0}},  {"half", {Type::Float, 0, 0.5}}, {"whole", {Type::Float, 0, 2}},
    {"word", {Type::String, 1, 0}}};
const std::vector<std::string> kStrings = {"", "hello n"};

std::string expanded(std::string_view text, const std::string& scope = "t.") {
  auto made = expand_property(text, scope, kConstants, kStrings);
  if (!made) return "error: " + made.error();
  CHECK(made->source.size() == made->text.size() + 1);
  for (const std::uint32_t offset : made->source) CHECK(offset <= text.size());
  return made->text;
}

}  // namespace

TEST_CASE("paths are prefixed, words and places are not") {
  CHECK(expanded("never a@CS && b[0].c@CS") == "never t.a@CS && t.b[0].c@CS");
  CHECK(expanded("a @ n leads to a@i") == "t.a @ n leads to t.a@i");
  CHECK(expanded("always can go && !can a.p") == "always can t.go && !can t.a.p");
  CHECK(expanded("eventually happens go") == "eventually happens t.go");
  CHECK(expanded("never ROOT.a@X", "deep.down.") == "never ROOT.a@X");
  CHECK(expanded("never a@X", "") == "never a@X");
  CHECK(expanded("never true@X") == "never t.true@X");
}

TEST_CASE("names of fairness are paths, its words are not") {
  CHECK(expanded("eventually a@X under weak, strong:go, weak : atoms") ==
        "eventually t.a@X under weak, strong:t.go, weak : atoms");
  CHECK(expanded("eventually a@X under weak:p[i].q, strong:p[*], weak:b[(i + 1) % n].c[*].d") ==
        "eventually t.a@X under weak:t.p[2].q, strong:t.p[*], weak:t.b[0].c[*].d");
  CHECK(expanded("forall k in weak: eventually weak[k]@X") == "forall k in t.weak: eventually t.weak[k]@X");
  CHECK(expanded("eventually under@X under weak:under") == "eventually t.under@X under weak:t.under");
  CHECK(expanded("never p[*]@X").starts_with("error: "));
}

TEST_CASE("constants stand for their values") {
  CHECK(expanded("always a.x < n && a.y > low") == "always t.a.x < 3 && t.a.y > (-4)");
  CHECK(expanded("always open || a.x != half * whole") == "always true || t.a.x != 0.5 * 2.0");
  CHECK(expanded("always a.s == word || a.s == \"n\"") == "always t.a.s == \"hello n\" || t.a.s == \"n\"");
  CHECK(expanded("always a.n == 1e3") == "always t.a.n == 1e3");
  CHECK(expanded("never unknown") == "never unknown");
}

TEST_CASE("indices are computed") {
  CHECK(expanded("never p[i]@X && p[(i + 1) % n].q[ n*2-1 ]@X") == "never t.p[2]@X && t.p[0].q[5]@X");
  CHECK(expanded("never p[-low / 3]@X") == "never t.p[1]@X");
  CHECK(expanded("never p[i - n]@X") == "error: an index is at least 0, this is -1");
  CHECK(expanded("never p[j]@X") ==
        "error: the index `[j]` is no number: it may name parameters and variables of loops");
  CHECK(expanded("never p[1 / (n - 3)]@X").starts_with("error: the index `[1 / (n - 3)]`"));
  CHECK(expanded("never p[2147483647 * 3]@X").starts_with("error: "));
  CHECK(expanded("never p[open]@X").starts_with("error: "));
  CHECK(expanded("never p[" + std::string(1000, '(') + "1]@X").starts_with("error: "));
  CHECK(expanded("never p[").starts_with("error: "));
}

TEST_CASE("variables of quantifiers stay, also in indices, up to the parentheses around them") {
  CHECK(expanded("never exists k in p: p[k]@X && p[(k + i) % n].q[i]@X") ==
        "never exists k in t.p: t.p[k]@X && t.p[(k + 2) % 3].q[2]@X");
  CHECK(expanded("always at most n k in low..n * 2: k != i || p[k + low].x == k") ==
        "always at most 3 k in (-4)..3 * 2: k != 2 || t.p[k + (-4)].x == k");
  CHECK(expanded("never exists k in 0..n: a.x == k") == "never exists k in 0..3: t.a.x == k");
  // `i` is a parameter around the parentheses.
  CHECK(expanded("never (exists i in p: p[i]@X && a.x == i) || p[i]@X || a.x == i") ==
        "never (exists i in t.p: t.p[i]@X && t.a.x == i) || t.p[2]@X || t.a.x == 2");
  CHECK(expanded("never exists k in p[i].q: forall m in k..n: p[i].q[m]@X") ==
        "never exists k in t.p[2].q: forall m in k..3: t.p[2].q[m]@X");
}

TEST_CASE("comments and line breaks become a blank; places are kept") {
  CHECK(expanded("  never // why\n\ta@X /* and\n how */ ") == "never t.a@X");
  CHECK(expanded("") == "");
  CHECK(expanded("  \n ") == "");
  CHECK(expanded("never /* open") == "never");
  CHECK(expanded("never \"open") == "never \"open");
  auto made = expand_property(" never\n  a@X", "t.", kConstants, kStrings);
  REQUIRE(made);
  CHECK(made->text == "never t.a@X");
  CHECK(made->source[made->text.find("t.a")] == 9);
  CHECK(made->source.back() == 12);
}
