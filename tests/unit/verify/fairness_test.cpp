// Fairness as it is written: names are resolved, each of an array, and slips are told with their column.
#include "compiler/verify/property/fairness.hpp"

#include <catch2/catch.hpp>

#include "compiler/verify/property/formula.hpp"
#include "tests/unit/verify/hand_made_nets.hpp"

namespace bip::verify {

namespace {

using test::HandMadeNet;

const char* const kRooms = R"(package p
  port type Signal()
  connector type One(Signal a)
    define a
  end
  atom type Lamp()
    export port Signal push(), hold()
    place OFF
    initial to OFF
    on push from OFF to OFF
    on hold from OFF to OFF
  end
  compound type Room(int n)
    component Lamp lamp[n]()
    for i in 0..n connector One push[i](lamp[i].push), hold[i](lamp[i].hold)
  end
  compound type Root()
    component Room a(2), b(1)
  end
end
)";

const System& rooms() {
  static const HandMadeNet kMade(kRooms);
  return *kMade.compiled.system;
}
Fairness read(const std::string& text) {
  Result<Fairness> read = read_fairness(text, rooms());
  INFO(text << ": " << (read ? "" : read.error()));
  REQUIRE(read);
  return *read;
}
std::string error_of(const std::string& text) {
  const Result<Fairness> read = read_fairness(text, rooms());
  return read ? "" : read.error();
}

}  // namespace

TEST_CASE("fairness has names") {
  for (const char* name : {"none", "weak", "strong", "weak:atoms", "strong:atoms", "weak,strong:a.push[0]",
                           "strong:a.lamp[1].hold,weak:b.lamp[0]", "weak:a.push[*],strong:atoms"}) {
    CHECK(name_of(read(name)) == name);
    CHECK(problem_of_fairness(name).empty());
  }
  CHECK(name_of(read(" weak : a.push[0] , strong ")) == "weak:a.push[0],strong");
  CHECK(read("none").is_none());
  CHECK(words_of(read("none")) == "no fairness is assumed");
  CHECK(words_of(read("weak:atoms")) == "weak fairness of components");
  CHECK(words_of(read("strong:a.push[0],weak,weak:b.lamp[0]")) ==
        "weak fairness of interactions, `b.lamp[0]`, strong fairness of `a.push[0]`");
}

TEST_CASE("fairness of an array is that of each position") {
  CHECK(certificate_text(read("weak:a.push[*]"), rooms()) ==
        "weak:connector:ROOT.a.push[0] weak:connector:ROOT.a.push[1]");
  CHECK(certificate_text(read("strong:a.lamp[*].hold,weak"), rooms()) ==
        "strong:port:ROOT.a.lamp[0].hold strong:port:ROOT.a.lamp[1].hold weak");
  CHECK(certificate_text(read("weak:a.lamp[*]"), rooms()) == "weak:atom:ROOT.a.lamp[0] weak:atom:ROOT.a.lamp[1]");
  CHECK(read("weak:a.lamp[*]").written.size() == 1);
}

TEST_CASE("fairness that cannot be read is told with its column") {
  CHECK(error_of("weak:a.pull[0]") == "column 6: there is no connector, port or component `a.pull[0]`");
  CHECK(error_of("weak:a.lamp[0].pull") == "column 6: component `a.lamp[0]` has no port `pull`");
  CHECK(error_of("weak, strong:a.lamp[*].pull") ==
        "column 14: no connector, port or component is called `a.lamp[*].pull`");
  CHECK(error_of("weak:a.push").ends_with("it is an array: `a.push[0]`, or `a.push[*]` for each of them"));
  CHECK(error_of("weak,weak") == "column 6: weak fairness of each interaction is said twice");
  CHECK(
      error_of("weak:a.push[*],strong:a.push[1]").starts_with("column 23: fairness of `a.push[1]` is weak or strong"));
  CHECK_FALSE(problem_of_fairness("just").empty());
  CHECK_FALSE(problem_of_fairness("").empty());
  CHECK_FALSE(problem_of_fairness("weak,").empty());
  CHECK_FALSE(problem_of_fairness("weak weak").empty());
  CHECK_FALSE(problem_of_fairness("none,weak").empty());
}

TEST_CASE("a property says its fairness itself") {
  const PropertyReader reader(rooms());
  Result<ParsedProperty> parsed = reader.read("always eventually happens a.push[0] under weak:a.push[0]");
  REQUIRE(parsed);
  REQUIRE(parsed->fairness);
  CHECK(name_of(*parsed->fairness) == "weak:a.push[0]");
  CHECK(parsed->formula.text == "always eventually happens a.push[0]");
  parsed = reader.read("always eventually happens a.push[0]");
  REQUIRE(parsed);
  CHECK_FALSE(parsed->fairness);
  CHECK(reader.read("eventually can b.push[0] under strong:b.push[7]").error() ==
        "column 39: there is no connector, port or component `b.push[7]`");
  CHECK_FALSE(reader.read("never a.lamp[0]@OFF under weak"));
}

}  // namespace bip::verify
