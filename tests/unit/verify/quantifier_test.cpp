// Quantifiers of properties: in each state of a run, a property with a quantifier has the value of the same property
// written out by hand. A quantifier that cannot be read has a message with its column.
#include <catch2/catch.hpp>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compiler/interp/interp.hpp"
#include "compiler/verify/portfolio/counted_property.hpp"
#include "compiler/verify/property/formula.hpp"
#include "compiler/verify/property/property.hpp"
#include "runtime/core/core.hpp"
#include "tests/unit/verify/hand_made_nets.hpp"

namespace bip::verify {

namespace {

using test::HandMadeNet;

const char* const kCars = R"(package p
  port type Signal()
  connector type One(Signal a)
    define a
  end
  atom type Car(int n)
    data int number = n, level = 0
    export port Signal go(), back()
    place HOME, OUT
    initial to HOME
    on go from HOME to OUT do { level = (level + number) % 3; }
    on back from OUT to HOME
  end
  compound type Fleet(int n)
    component Car car[n](0)
    for i in 0..n connector One go[i](car[i].go), back[i](car[i].back)
  end
  compound type Root()
    component Fleet fleet[2](3)
    component Car car[5](2), lone(1)
    for i in 0..5 connector One go[i](car[i].go), back[i](car[i].back)
    connector One leave(lone.go), come(lone.back)
  end
end
)";

Property property_of_text(const HandMadeNet& made, const std::string& text) {
  INFO(text);
  Result<Property> property = parse_property(text, *made.compiled.system);
  if (!property) FAIL(property.error());
  return std::move(*property);
}
std::string problem_of(const HandMadeNet& made, const std::string& text) {
  Result<ParsedProperty> parsed = PropertyReader(*made.compiled.system).read(text);
  return parsed ? "" : parsed.error();
}

// `E0 op E1 op …`, with each number in the place of `#`.
std::string written_out(const std::string& pattern, const std::string& op, const std::vector<int>& numbers) {
  std::string text;
  for (const int number : numbers) {
    if (!text.empty()) text += ' ' + op + ' ';
    for (const char c : pattern) text += c == '#' ? std::to_string(number) : std::string(1, c);
  }
  return text;
}

}  // namespace

TEST_CASE("a quantifier says what is written out") {
  const HandMadeNet made(kCars);
  const std::vector<int> all = {0, 1, 2, 3, 4};
  std::string pairs, triples;
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < i; ++j) {
      const std::string two = "car[" + std::to_string(i) + "]@OUT && car[" + std::to_string(j) + "]@OUT";
      pairs += (pairs.empty() ? "" : " || ") + two;
      for (int k = 0; k < j; ++k)
        triples += (triples.empty() ? "" : " || ") + two + " && car[" + std::to_string(k) + "]@OUT";
    }
  }
  const std::vector<std::pair<std::string, std::string>> same = {
      {"never exists i in car: car[i]@OUT", "never " + written_out("car[#]@OUT", "||", all)},
      {"always forall i in car: car[i]@OUT", "always " + written_out("car[#]@OUT", "&&", all)},
      {"never exists i in 1..3: car[i]@OUT && lone@OUT", "never (car[1]@OUT && lone@OUT) || (car[2]@OUT && lone@OUT)"},
      {"never lone@OUT && (exists i in car: car[i]@OUT) && car[0]@HOME",
       "never lone@OUT && (" + written_out("car[#]@OUT", "||", all) + ") && car[0]@HOME"},
      {"never exists i in car: exists j in 0..i: car[i]@OUT && car[j]@OUT", "never " + pairs},
      {"never exists i in car: exists j in car: i != j && car[i]@OUT && car[j]@OUT", "never " + pairs},
      {"always at most 1 i in car: car[i]@OUT", "never " + pairs},
      {"always !(at least 2 i in car: car[i]@OUT)", "never " + pairs},
      {"always at most 2 k in car: car[k]@OUT", "never " + triples},
      {"always exactly 1 i in car: car[i]@OUT",
       "never (" + pairs + ") || !(" + written_out("car[#]@OUT", "||", all) + ")"},
      {"always at least 5 i in car: car[i]@OUT", "always " + written_out("car[#]@OUT", "&&", all)},
      {"always at most 4 i in car: car[i]@OUT", "never " + written_out("car[#]@OUT", "&&", all)},
      {"never exists i in car: car[(i + 1) % 5].level == i",
       "never car[1].level == 0 || car[2].level == 1 || car[3].level == 2 || car[4].level == 3 || car[0].level == 4"},
      {"never exists i in fleet: forall j in fleet[i].car: fleet[i].car[j]@OUT",
       "never (fleet[0].car[0]@OUT && fleet[0].car[1]@OUT && fleet[0].car[2]@OUT) || (fleet[1].car[0]@OUT && "
       "fleet[1].car[1]@OUT && fleet[1].car[2]@OUT)"},
      // What variables decide, and ranges without positions.
      {"never exists i in car: i > 2 && car[i]@OUT", "never car[3]@OUT || car[4]@OUT"},
      {"always at most 3 i in car: i < 2 || car[i]@OUT",
       "never car[2]@OUT && car[3]@OUT || car[2]@OUT && car[4]@OUT || car[3]@OUT && car[4]@OUT"},
      {"never (exists i in 3..3: car[i]@OUT) || lone@OUT", "never lone@OUT"},
      {"always (forall i in 3..0: car[i + 9]@OUT) && lone@OUT", "always lone@OUT"},
      {"always at most 0 i in 0..0: car[i]@OUT", "always true"},
      {"always at most 7 i in car: car[i]@OUT", "always true"},
      {"never exists i in car: i == 7", "never false"},
  };
  const interp::Interpreter interpreter(*made.compiled.lowered);
  for (const auto& [quantified, plain] : same) {
    INFO(quantified << " against " << plain);
    const Property a = property_of_text(made, quantified), b = property_of_text(made, plain);
    CHECK(a.text == quantified);
    rt::Core core(made.compiled.lowered->image);
    REQUIRE(core.initialize());
    int broken = 0;
    for (std::uint64_t step = 1, seed = 7; step < 2'000; ++step) {
      REQUIRE(is_broken(a, core) == is_broken(b, core));
      broken += is_broken(a, core) ? 1 : 0;
      seed = seed * 6364136223846793005U + 1442695040888963407U;
      REQUIRE(core.fire((seed >> 33) % core.candidate_count()));
    }
    CHECK((broken > 0 || plain == "always true" || plain == "never false"));
  }
}

TEST_CASE("quantifiers over runs and over what is possible") {
  const HandMadeNet made(kCars);
  const auto form = [&](const std::string& text) {
    INFO(text);
    Result<ParsedProperty> parsed = PropertyReader(*made.compiled.system).read(text);
    REQUIRE(parsed);
  };
  form("forall i in car: car[i]@OUT leads to car[i]@HOME");
  form("forall i in car: possibly car[i]@OUT");
  form("(exists i in car: car[i]@OUT) leads to (forall i in car: car[i]@HOME)");
  form("eventually exists i in car: happens car[i].go");
}

TEST_CASE("of interchangeable components the first ones stand for all") {
  const HandMadeNet made(kCars);
  const auto first = [&](const std::string& text) -> std::string {
    INFO(text);
    Result<ParsedProperty> parsed = PropertyReader(*made.compiled.system).read(text);
    REQUIRE(parsed);
    const std::optional<Property> found = with_first_conditions(parsed->state, made.compiled.lowered->image);
    if (found) CHECK(found->text == text);
    return found ? certificate_text(*found, *made.compiled.system) : "";
  };
  const std::string zero = "(at ROOT.car[0] OUT)", one = "(at ROOT.car[1] OUT)", lone = "(at ROOT.lone OUT)";
  CHECK(first("never exists i in car: car[i]@OUT") == zero);
  CHECK(first("always at most 1 i in car: car[i]@OUT") == "(and " + zero + " " + one + ")");
  CHECK(first("never at least 2 i in car: car[i]@OUT") == "(and " + zero + " " + one + ")");
  CHECK(first("never lone@OUT && exists i in car: car[i]@OUT") == "(and " + lone + " " + zero + ")");
  CHECK(first("never (at least 2 i in car: car[i]@OUT) && lone@OUT") ==
        "(and " + lone + " (and " + zero + " " + one + "))");
  CHECK(first("never exists i in 1..4: car[0]@OUT && car[i]@OUT") == "(and " + zero + " " + one + ")");
  CHECK(first("never exists i in fleet: fleet[i].car[1]@OUT") == "(at ROOT.fleet[0].car[1] OUT)");
  // The whole, what is beside it names one of them, conditions that differ, two of them in one, no quantifier.
  for (const char* other :
       {"always forall i in car: car[i]@OUT", "always exactly 1 i in car: car[i]@OUT",
        "always at most 4 i in car: car[i]@OUT", "never car[3]@OUT && exists i in car: car[i]@HOME",
        "never exists i in car: car[i].level == i", "never exists i in car: car[i]@OUT && car[(i + 1) % 5]@OUT",
        "never lone@OUT || exists i in car: car[i]@OUT", "never car[0]@OUT && car[1]@OUT",
        "always exists i in car: car[i]@OUT", "never exists i in car: lone@OUT"}) {
    INFO(other);
    CHECK(first(other).empty());
  }
}

TEST_CASE("what is wrong with a quantifier") {
  const HandMadeNet made(kCars);
  CHECK_THAT(problem_of(made, "always forall (i : int) car[i]@OUT"),
             Catch::StartsWith("column 15: quantifiers are written"));
  CHECK_THAT(problem_of(made, "always forall car[0]@OUT"), Catch::StartsWith("column 15: quantifiers are written"));
  CHECK_THAT(problem_of(made, "always forall i in bus: bus[i]@OUT"),
             Catch::StartsWith("column 20: there is no array of components `bus`"));
  CHECK_THAT(problem_of(made, "always forall i in car car[i]@OUT"), Catch::StartsWith("column 24: a `:` was expected"));
  CHECK_THAT(problem_of(made, "always forall i in 0..9: car[i]@OUT"),
             Catch::StartsWith("column 26: there is no component `car[5]`"));
  CHECK_THAT(problem_of(made, "always forall i in 0..2: car[i - 1]@OUT"),
             Catch::Contains("an index is at least 0, this is -1"));
  CHECK_THAT(problem_of(made, "always forall i in 0..2: car[k]@OUT"), Catch::Contains("this index is no number"));
  CHECK_THAT(problem_of(made, "always forall i in 0..2: car[i].level"), Catch::Contains("a condition was expected"));
  CHECK_THAT(problem_of(made, "always at most 1 i in car: happens car[i].go"),
             Catch::Contains("conditions on one state are counted"));
  CHECK_THAT(problem_of(made, "always forall i in 0: car[i]@OUT"), Catch::Contains("a range has two bounds"));
  CHECK_THAT(problem_of(made, "never exists i in 0..3000: exists j in 0..3000: car[i % 5]@OUT"), !Catch::Equals(""));
}

}  // namespace bip::verify
