// Proofs of pairs of like components against whole zone graphs, on random systems of three and four: what is proved
// must hold.
#include <catch2/catch.hpp>

#include <cstdlib>
#include <string>

#include "compiler/interp/interp.hpp"
#include "compiler/verify/timed/like_components.hpp"
#include "compiler/verify/timed/prove_pairs.hpp"
#include "runtime/explore/zones.hpp"
#include "runtime/include/bip/prng.hpp"
#include "tools/gen/compiled.hpp"

namespace {

using namespace bip;

rt::PartReport explore_local(const System& part, const rt::ExploreOptions& options, const rt::PartQuestion& question) {
  const std::unique_ptr<lower::LoweredSystem> lowered = lower::lower(part, "part");
  const interp::Interpreter interpreter(*lowered);
  return rt::explore_part(lowered->image, options, question);
}

// Processes that differ in a number, and a variable that may hold one.
class PairSystemWriter {
 public:
  explicit PairSystemWriter(std::uint64_t seed) : random_(seed * 2654435761u + 3) {}

  std::string model(std::uint64_t size) {
    std::string text =
        "package t\n  port type S()\n  port type N(int n)\n  connector type One(S a)\n    define a\n  end\n"
        "  connector type Two(S a, S b)\n    define a b\n  end\n"
        "  connector type Put(N a, N b)\n    define a b\n    on a b down { b.n = a.n; }\n  end\n"
        "  connector type Same(N a, N b)\n    define a b\n    on a b provided (a.n == b.n)\n  end\n"
        "  connector type Other(N a, N b)\n    define a b\n    on a b provided (a.n != b.n)\n  end\n";
    text +=
        "  atom type Process(int me)\n    clock x\n    data int n = me\n"
        "    export port S p(), q(), r(), all()\n    export port N put(n), see(n)\n";
    text += body("x", {"p", "q", "r", "all", "put", "see"}, false);
    text +=
        "  atom type Middle()\n    clock y\n    data int n = 0\n    export port S p(), q(), all()\n"
        "    export port N put(n), see(n)\n";
    text += body("y", {"p", "q", "all", "put", "see"}, true);
    text += "  compound type Row(int n)\n    for i in 0..n component Process a[i](i + 1)\n    component Middle m()\n";
    text += "    for i in 0..n {\n      connector One r[i](a[i].r)\n";
    const char* const ports[] = {"p", "q"};
    const std::uint64_t count = 1 + below(3);
    for (std::uint64_t k = 0; k < count; ++k)
      text += std::string("      connector Two c") + std::to_string(k) + "[i](a[i]." + ports[below(2)] + ", m." +
              ports[below(2)] + ")\n";
    if (below(3) != 0) text += "      connector Put w[i](a[i].put, m.put)\n";
    const std::uint64_t sees = below(4);
    if (sees != 0)
      text += std::string("      connector ") + (sees == 3 ? "Other" : "Same") + " s[i](a[i].see, m.see)\n";
    text += "    }\n";
    if (below(3) == 0) text += "    connector all(m.all, a[*].all)\n      define [m.all, a[*].all]\n";
    return text + "  end\n  compound type Root()\n    component Row row(" + std::to_string(size) + ")\n  end\nend\n";
  }

  [[nodiscard]] std::string property() {
    std::string text = "never row.a[0]@S" + std::to_string(below(places_[0]));
    if (below(4) != 0) text += " && row.a[1]@S" + std::to_string(below(places_[0]));
    if (below(4) == 0) text += " && row.m@S" + std::to_string(below(places_[1]));
    return text;
  }

 private:
  std::uint64_t below(std::uint64_t n) { return random_.below(n); }

  std::string body(const std::string& clock, const std::vector<std::string>& ports, bool is_middle) {
    const std::uint64_t places = is_middle ? 1 + below(2) : 2 + below(2);
    places_[is_middle ? 1 : 0] = places;
    std::string text = "    place S0";
    for (std::uint64_t k = 1; k < places; ++k) text += ", S" + std::to_string(k);
    text += "\n    initial to S0\n";
    for (const std::string& port : ports) {
      for (std::uint64_t place = 0; place < places; ++place) {
        if (below(2) != 0 && place != 0) continue;
        text += "    on " + port + " from S" + std::to_string(place) + " to S" + std::to_string(below(places));
        std::string guard;
        if (below(3) == 0) guard = clock + (below(2) == 0 ? " >= " : " <= ") + std::to_string(1 + below(3));
        if (is_middle && below(3) == 0) guard += (guard.empty() ? "" : " && ") + std::string("n == 0");
        if (!guard.empty()) text += " provided (" + guard + ")";
        std::string action;
        if (below(3) != 0) action += " " + clock + " = 0;";
        if (is_middle && port != "put" && below(4) == 0) action += " n = 0;";
        if (!action.empty()) text += " do {" + action + " }";
        text += "\n";
      }
    }
    if (below(3) != 0)
      text += "    invariant soon at S" + std::to_string(below(places)) + " provided (" + clock +
              " <= " + std::to_string(2 + below(2)) + ")\n";
    return text + "  end\n";
  }

  rt::Prng random_;
  std::uint64_t places_[2] = {1, 1};
};

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

}  // namespace

TEST_CASE("pairs of like components prove nothing that a zone graph refutes") {
  const char* const wanted = std::getenv("BIP_PAIR_SEEDS");
  const std::uint64_t seeds = wanted != nullptr ? std::strtoull(wanted, nullptr, 10) : 250;
  int proved = 0, compared = 0, broken = 0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    PairSystemWriter writer(seed);
    const std::string text = writer.model(3 + seed % 2);
    const std::optional<PairQuestion> asked = ask_of_pair(text, writer.property());
    const System& system = *asked->compiled.system;
    const interp::Interpreter interpreter(*asked->compiled.lowered);
    rt::ExploreOptions options;
    options.limit = 20000;
    options.predicate = [&](const rt::Core& core) { return verify::is_broken(asked->property, core); };
    const rt::ZoneReport whole = rt::explore_zones(asked->compiled.lowered->image, options);
    if (!whole.has_match && whole.end != rt::ExploreEnd::Complete) continue;
    ++compared;
    broken += whole.has_match ? 1 : 0;
    const verify::TimeProof proof =
        verify::prove_state_by_pairs(system, asked->property, explore_local, verify::within_seconds(20));
    INFO("seed " << seed << ": " << asked->property.text << "\n" << text);
    CHECK_FALSE((proof.is_proved && whole.has_match));
    proved += proof.is_proved ? 1 : 0;
  }
  // Of 400: 42 hold, 23 of them are proved.
  INFO(proved << " of " << compared << " proved, " << broken << " broken");
  CHECK(proved >= compared / 50);
  CHECK(broken > compared / 2);
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
