// Branching time on a system with known answers: how properties are read, what holds, the runs that show it; and that
// the first part of a graph says nothing that the whole one refutes.
#include <catch2/catch.hpp>

#include <string>

#include "compiler/interp/interp.hpp"
#include "compiler/verify/branching/decide_branching.hpp"
#include "compiler/verify/branching/label_states.hpp"
#include "compiler/verify/liveness/graph_rounds.hpp"
#include "compiler/verify/property/formula.hpp"
#include "tests/unit/verify/hand_made_nets.hpp"

namespace bip::verify {

namespace {

using test::HandMadeNet;

// It comes home as long as its battery is not empty, and can divide by 0.
const char* const kRobot = R"(package p
  port type Signal()
  connector type One(Signal a)
    define a
  end
  atom type Robot(int charge)
    data int battery = charge
    data int share = 0
    export port Signal go(), back(), load(), jam()
    place HOME, OUT, JAMMED
    initial to HOME
    on go from HOME to OUT provided (battery > 0) do { battery = battery - 1; }
    on back from OUT to HOME provided (battery > 0)
    on load from HOME to HOME do { battery = charge; }
    on jam from OUT to JAMMED provided (battery == 1)
    on back from JAMMED to JAMMED do { share = 1 / (battery - 1); }
  end
  compound type Root()
    component Robot r(3)
    connector One go(r.go), back(r.back), load(r.load), jam(r.jam)
  end
end
)";

BranchingFormula read(const HandMadeNet& made, const std::string& property) {
  INFO(property);
  Result<ParsedProperty> parsed = PropertyReader(*made.compiled.system).read(property);
  REQUIRE(parsed);
  REQUIRE(parsed->form == PropertyForm::Branching);
  return std::move(parsed->branching);
}
std::string error_of(const HandMadeNet& made, const std::string& property) {
  const Result<ParsedProperty> parsed = PropertyReader(*made.compiled.system).read(property);
  return parsed ? "" : parsed.error();
}
BranchingResult decide(const HandMadeNet& made, const std::string& property) {
  const interp::Interpreter interpreter(*made.compiled.lowered);
  return decide_branching(read(made, property), made.compiled.lowered->image, {});
}

}  // namespace

TEST_CASE("what begins with `possibly` and has one word negates a property of all runs") {
  const HandMadeNet robot(kRobot);
  const auto negation = [&](const std::string& property) { return read(robot, property).negation; };
  CHECK(negation("possibly r@HOME") == "never (r@HOME)");
  CHECK(negation(" possibly  ( r@OUT && r.battery == 1 ) ") == "never (r@OUT && r.battery == 1)");
  CHECK(negation("possibly !r@HOME") == "never (!r@HOME)");
  CHECK(negation("possibly (r@HOME) || (r@OUT)") == "never ((r@HOME) || (r@OUT))");
  CHECK(negation("possibly eventually (r@HOME)") == "never (r@HOME)");
  CHECK(negation("(possibly always r@HOME)") == "eventually !(r@HOME)");
  CHECK(negation("possibly never r@HOME") == "eventually (r@HOME)");
  CHECK(negation("possibly next r@HOME") == "!(next r@HOME)");
  CHECK(negation("possibly (r@HOME until r@OUT)") == "!(r@HOME until r@OUT)");
  CHECK(negation("possibly (r@HOME unless r@OUT)") == "!(r@HOME unless r@OUT)");
  // More than one word, or all runs first.
  for (const char* other : {"always possibly r@HOME", "possibly always possibly r@HOME", "!(possibly r@HOME)",
                            "(possibly r@HOME) && (possibly r@OUT)", "possibly eventually (always r@OUT)"})
    CHECK(negation(other).empty());
}

TEST_CASE("words of branching time are read as operators of CTL") {
  const HandMadeNet robot(kRobot);
  const auto text = [&](const std::string& property) {
    return certificate_text(read(robot, property), *robot.compiled.system).value();
  };
  const std::string home = "(at ROOT.r HOME)", out = "(at ROOT.r OUT)";
  CHECK(text("possibly r@HOME") == "(some-until true " + home + ")");
  CHECK(text("possibly eventually r@HOME") == text("possibly r@HOME"));
  CHECK(text("possibly always r@HOME") == "(some-release false " + home + ")");
  CHECK(text("possibly never r@OUT") == "(some-release false (not " + out + "))");
  CHECK(text("possibly next r@OUT") == "(some-next " + out + ")");
  CHECK(text("possibly (r@HOME until r@OUT)") == "(some-until " + home + ' ' + out + ")");
  CHECK(text("possibly (r@HOME unless r@OUT)") == "(some-release " + out + " (or " + home + ' ' + out + "))");
  CHECK(text("always possibly r@HOME") == "(all-release false (some-until true " + home + "))");
  CHECK(text("never possibly r@OUT") == "(all-release false (all-release false (not " + out + ")))");
  CHECK(text("always (r@OUT implies possibly r@HOME)") ==
        "(all-release false (or (not " + out + ") (some-until true " + home + ")))");
  CHECK(text("r@OUT leads to possibly r@HOME") ==
        "(all-release false (or (not " + out + ") (all-until true (some-until true " + home + "))))");
  CHECK(text("possibly eventually always r@OUT") == "(some-until true (all-release false " + out + "))");
  CHECK(text("!(possibly (r@HOME until r@OUT))") == "(all-release (not " + home + ") (not " + out + "))");
}

TEST_CASE("what CTL does not have is refused with its place") {
  const HandMadeNet robot(kRobot);
  CHECK(error_of(robot, "possibly ((eventually r@OUT) && (always r@HOME))").starts_with("column 1: `possibly` cannot"));
  CHECK(
      error_of(robot, "always (possibly (r@OUT leads to r@HOME))").starts_with("column 19: `possibly (… leads to …)`"));
  CHECK(error_of(robot, "always possibly (happens go)").starts_with("column 18: `happens` speaks of a step"));
  CHECK(error_of(robot, "possibly (once r@OUT)").starts_with("column 11: a word that looks back"));
  // Words that `possibly` makes ones of some run are parts of conditions on states.
  CHECK(error_of(robot, "possibly ((possibly r@OUT) && r@HOME)").empty());
}

TEST_CASE("what the robot can do from each state") {
  const HandMadeNet robot(kRobot);
  const auto holds = [&](const std::string& property) { return decide(robot, property).outcome == Outcome::Holds; };
  CHECK(holds("possibly r@OUT"));
  CHECK(holds("possibly always r@HOME"));
  CHECK(holds("possibly next r@OUT"));
  CHECK(holds("always (r@HOME implies possibly r.battery == 3)"));
  CHECK(holds("possibly (r@HOME until r@OUT)"));
  CHECK(holds("(possibly r@JAMMED) && !(possibly r.battery > 3)"));
  CHECK(holds("possibly eventually (always r@OUT)"));
  CHECK_FALSE(holds("always possibly r@HOME"));
  CHECK_FALSE(holds("possibly r.share > 0"));
  CHECK_FALSE(holds("eventually possibly r.battery == 5"));
}

TEST_CASE("a run leads to where something is not possible any more") {
  const HandMadeNet robot(kRobot);
  const BranchingResult empty = decide(robot, "always possibly r@HOME");
  CHECK(empty.outcome == Outcome::Violated);
  // go, back, go, back, go; or jam in the place of the last two.
  CHECK(empty.choices.size() == 4);
  REQUIRE(empty.claims.size() == 1);
  CHECK(empty.claims[0].of_run == "reaches `r@HOME`");
  CHECK(empty.claims[0].position == 4);
  CHECK(empty.claims[0].states == 1);
  CHECK_FALSE(empty.claims[0].has_run);
  CHECK(empty.only_errors_follow);
}

TEST_CASE("a run shows what is possible") {
  const HandMadeNet robot(kRobot);
  const BranchingResult found = decide(robot, "possibly r@JAMMED");
  CHECK(found.outcome == Outcome::Holds);
  CHECK(found.choices.size() == 4);
  const BranchingResult stays = decide(robot, "possibly always r@HOME");
  CHECK(stays.repeats);
  CHECK(stays.choices.size() == 1);
  CHECK(stays.cycle == 0);
}

TEST_CASE("a state in which all steps fail repeats") {
  const HandMadeNet robot(kRobot);
  CHECK(decide(robot, "possibly eventually (always r@JAMMED)").outcome == Outcome::Holds);
  CHECK(decide(robot, "possibly eventually (r@JAMMED && (possibly next r@JAMMED))").outcome == Outcome::Holds);
}

TEST_CASE("bounds of a part of the graph lie around the labels of the whole") {
  const HandMadeNet robot(kRobot);
  const rt::Image& image = robot.compiled.lowered->image;
  const interp::Interpreter interpreter(*robot.compiled.lowered);
  std::size_t decided = 0;
  for (const char* const property :
       {"always possibly r@HOME", "possibly always r@HOME", "possibly r@JAMMED", "eventually possibly next r@JAMMED",
        "possibly (r.battery == 3 unless (r@OUT && (possibly next r@HOME)))", "always next possibly r.battery < 2"}) {
    const BranchingFormula formula = read(robot, property);
    const auto graph_of = [&](std::uint32_t states) {
      auto graph =
          std::make_unique<rt::StateGraph>(image, rt::GraphOptions{.predicates = predicates_of(formula.states)});
      REQUIRE(graph->initialize());
      REQUIRE(graph->grow(states) == rt::ExploreEnd::Complete);
      return graph;
    };
    const auto labels = [&](const rt::StateGraph& graph, Bound bound) {
      return label_states(formula, graph, Predecessors(graph), bound, {}).value();
    };
    const auto whole = graph_of(1000);
    REQUIRE(whole->is_complete());
    const std::vector<StateSet> truth = labels(*whole, Bound::Surely);
    for (std::uint32_t size = 0; size <= whole->states(); ++size) {
      const auto part = graph_of(size);
      const std::vector<StateSet> surely = labels(*part, Bound::Surely), possibly = labels(*part, Bound::Possibly);
      for (std::uint32_t node = 0; node < formula.nodes.size(); ++node) {
        for (std::uint32_t state = 0; state < part->states(); ++state) {
          INFO(property << ", " << size << " states expanded, node " << node << ", state " << state);
          CHECK(surely[node].has(state) <= truth[node].has(state));
          CHECK(truth[node].has(state) <= possibly[node].has(state));
        }
      }
      if (!part->is_complete() && surely[formula.root].has(0) == possibly[formula.root].has(0)) ++decided;
    }
  }
  // Some of them need no more than a part.
  CHECK(decided > 5);
}

}  // namespace bip::verify
