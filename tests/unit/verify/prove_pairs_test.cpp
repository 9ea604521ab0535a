// Proofs of pairs of like components against whole zone graphs, on random systems of three and four: what is proved
// must hold.
#include <catch2/catch.hpp>

#include <cstdlib>
#include <string>

#include "compiler/interp/interp.hpp"
#include "compiler/verify/portfolio/counted_property.hpp"
#include "compiler/verify/property/formula.hpp"
#include "compiler/verify/timed/like_components.hpp"
#include "compiler/verify/timed/prove_pairs.hpp"
#include "runtime/explore/zones.hpp"
#include "tests/verify/pair_systems.hpp"
#include "tools/gen/compiled.hpp"

namespace {

using namespace bip;

rt::PartReport explore_local(const System& part, const rt::ExploreOptions& options, const rt::PartQuestion& question) {
  const std::unique_ptr<lower::LoweredSystem> lowered = lower::lower(part, "part");
  const interp::Interpreter interpreter(*lowered);
  return rt::explore_part(lowered->image, options, question);
}

struct PairQuestion {
  gen::Compiled compiled;
  verify::Property property;
};
std::optional<PairQuestion> ask_of_pair(const std::string& text, const std::string& property) {
  PairQuestion asked{gen::compile_texts({text}), {}};
  INFO(text << asked.compiled.problem);
  REQUIRE(asked.compiled.problem.empty());
  Result<verify::Property> parsed = verify::parse_property(property, *asked.compiled.system);
  REQUIRE(parsed);
  asked.property = std::move(*parsed);
  return asked;
}

// What is proved by pairs, against zone graphs of the whole.
class PairComparison {
 public:
  // `by_pairs` stands for `whole`.
  void compare(const gen::Compiled& c, const verify::Property& whole, const verify::Property& by_pairs) {
    const interp::Interpreter interpreter(*c.lowered);
    rt::ExploreOptions options;
    options.limit = 20000;
    options.predicate = [&](const rt::Core& core) { return verify::is_broken(whole, core); };
    const rt::ZoneReport zones = rt::explore_zones(c.lowered->image, options);
    if (!zones.has_match && zones.end != rt::ExploreEnd::Complete) return;
    ++compared_;
    broken_ += zones.has_match ? 1 : 0;
    const verify::TimeProof proof =
        verify::prove_state_by_pairs(*c.system, by_pairs, explore_local, verify::within_seconds(20));
    CHECK_FALSE((proof.is_proved && zones.has_match));
    proved_ += proof.is_proved ? 1 : 0;
  }
  // Of 400: 42 hold, 23 of them are proved.
  void check_counts() const {
    INFO(proved_ << " of " << compared_ << " proved, " << broken_ << " broken");
    CHECK(proved_ >= compared_ / 50);
    CHECK(broken_ > compared_ / 2);
  }
  static std::uint64_t seeds() {
    const char* const wanted = std::getenv("BIP_PAIR_SEEDS");
    return wanted != nullptr ? std::strtoull(wanted, nullptr, 10) : 250;
  }

 private:
  int proved_ = 0, compared_ = 0, broken_ = 0;
};

}  // namespace

TEST_CASE("pairs of like components prove nothing that a zone graph refutes") {
  PairComparison comparison;
  for (std::uint64_t seed = 1; seed <= PairComparison::seeds(); ++seed) {
    verify::test::PairSystemWriter writer(seed);
    const std::string text = writer.model(3 + seed % 2);
    const std::optional<PairQuestion> asked = ask_of_pair(text, writer.property());
    INFO("seed " << seed << ": " << asked->property.text << "\n" << text);
    comparison.compare(asked->compiled, asked->property, asked->property);
  }
  comparison.check_counts();
}

TEST_CASE("the first of like components stand for all of a quantifier") {
  PairComparison comparison;
  for (std::uint64_t seed = 1; seed <= PairComparison::seeds(); ++seed) {
    verify::test::PairSystemWriter writer(seed);
    const std::string text = writer.model(3 + seed % 2);
    const gen::Compiled c = gen::compile_texts({text});
    REQUIRE(c.problem.empty());
    Result<verify::ParsedProperty> asked = verify::PropertyReader(*c.system).read(writer.counted_property());
    REQUIRE(asked);
    INFO("seed " << seed << ": " << asked->state.text << "\n" << text);
    const std::optional<verify::Property> first = verify::with_first_of_array(asked->state, *c.system);
    REQUIRE(first);
    comparison.compare(c, asked->state, *first);
  }
  comparison.check_counts();
}

TEST_CASE("like components: what tells them apart is seen") {
  const auto likeness = [](const std::string& code, const std::string& variable_code, const std::string& row) {
    const std::string text =
        "package t\n  port type S()\n  port type N(int n)\n  connector type Two(S a, S b)\n    define a b\n  end\n"
        "  connector type Put(N a, N b)\n    define a b\n    on a b down { b.n = a.n; }\n  end\n"
        "  connector type More(N a, N b)\n    define a b\n    on a b down { b.n = a.n + 1; }\n  end\n"
        "  connector type Less(N a, N b)\n    define a b\n    on a b provided (a.n < b.n)\n  end\n"
        "  connector type Same(N a, N b)\n    define a b\n    on a b provided (a.n == b.n)\n  end\n"
        "  @SuppressWarning(unboundcomponentport)\n"
        "  atom type Process(int me)\n    data int n = me\n    export port S p()\n    export port N put(n)\n"
        "    place A, B\n    initial to A\n    on p from A to B\n    on put from B to A\n" +
        code + "  end\n  atom type Middle()\n    data int n = 0\n    export port S p()\n    export port N put(n)\n" +
        "    place M\n    initial to M\n    on p from M to M\n    on put from M to M\n" + variable_code +
        "  end\n  compound type Row(int n)\n    for i in 0..n component Process a[i](i + 1)\n"
        "    component Middle m(), k()\n"
        "    for i in 0..n connector Two p[i](a[i].p, m.p)\n" +
        row + "  end\n  compound type Root()\n    component Row row(4)\n  end\nend\n";
    const gen::Compiled c = gen::compile_texts({text});
    INFO(text << c.problem);
    REQUIRE(c.problem.empty());
    const verify::Neighbours neighbours(*c.system);
    std::string reason;
    std::optional<verify::LikeComponents> like = verify::find_like_components(*c.system, neighbours, 0, reason);
    return like ? "alike, " + std::to_string(like->numbers.size()) + " numbers in " +
                      std::to_string(like->number_outside.size()) + " variables outside"
                : reason;
  };
  const std::string put = "    for i in 0..n connector Put put[i](a[i].put, m.put)\n";
  CHECK(likeness("", "", "") == "alike, 4 numbers in 0 variables outside");
  CHECK(likeness("", "", put) == "alike, 4 numbers in 1 variables outside");
  CHECK(likeness("", "    on p from M to M provided (n == 0) do { n = 0; }\n", put) ==
        "alike, 4 numbers in 1 variables outside");
  // A constant that is one of the numbers, arithmetic, an order, a copy from one variable to another.
  CHECK(likeness("", "    on p from M to M provided (n == 2)\n", put) == "`ROOT.row.m` computes with numbers");
  CHECK(likeness("", "    on p from M to M provided (n == 0) do { n = n + 1; }\n", put) ==
        "`ROOT.row.m` computes with numbers");
  CHECK(likeness("", "", put + "    for i in 0..n connector Less less[i](a[i].put, m.put)\n") ==
        "`ROOT.row.less[0]` computes with numbers");
  CHECK(likeness("", "", "    for i in 0..n connector More put[i](a[i].put, m.put)\n") ==
        "`ROOT.row.put[0]` computes with numbers");
  CHECK(likeness("", "", put + "    connector Put copy(m.put, k.put)\n") == "`ROOT.row.copy` computes with numbers");
  CHECK(likeness("", "", put + "    connector Put second(a[1].put, k.put)\n") ==
        "the connectors of the array's components differ");
  CHECK(likeness("", "",
                 put + "    for i in 0..n connector Put second[i](a[i].put, k.put)\n"
                       "    connector Same same(m.put, k.put)\n") == "`ROOT.row.same` computes with numbers");
  CHECK(likeness("    on p from B to B provided (n == 2)\n", "", put) == "code of `Process` reads numbers");
  CHECK(likeness("", "", "    for i in 0..n connector Two pass[i](a[i].p, a[(i + 1) % n].p)\n") ==
        "`ROOT.row.pass[0]` does not treat all alike");
}
