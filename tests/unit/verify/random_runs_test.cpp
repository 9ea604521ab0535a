// Random runs: what they run into is replayed, what they do not find they do not claim.
#include <catch2/catch.hpp>

#include "compiler/interp/interp.hpp"
#include "compiler/verify/portfolio/random_runs.hpp"
#include "tools/gen/compiled.hpp"

namespace {

using namespace bip;

// Counts up to `last`, where it stops or divides by zero; half of the steps go back to 0 if it may go back.
std::string counter(const std::string& back, const std::string& action) {
  return "package counter\n  port type Signal()\n  connector type One(Signal a)\n    define a\n  end\n"
         "  atom type Counter()\n    data int n = 0\n    export port Signal more(), back()\n    place S\n    initial "
         "to "
         "S\n"
         "    on more from S to S provided (n < 20) do { n = n + 1; " +
         action + " }\n    on back from S to S provided (" + back +
         ") do { n = 0; }\n  end\n  compound type Root()\n    component Counter c()\n"
         "    connector One m(c.more), b(c.back)\n  end\nend\n";
}

struct Found {
  verify::SearchResult result;
  bool is_replayed = false;
};
Found look(const std::string& text, const verify::SearchGoal& goal, const verify::RandomRunLimits& limits) {
  const gen::Compiled c = gen::compile_texts({text});
  REQUIRE(c.problem.empty());
  const interp::Interpreter interpreter(*c.lowered);
  Found found{verify::run_at_random(c.lowered->image, goal, limits)};
  found.is_replayed = verify::reaches(c.lowered->image, goal, found.result.choices);
  return found;
}
verify::RandomRunLimits limits(std::uint64_t runs, std::uint64_t steps) {
  return {.cancellation = verify::within_seconds(20), .runs = runs, .steps = steps};
}

TEST_CASE("random runs meet a deadlock") {
  verify::SearchGoal goal;
  goal.stuck = true;
  const Found found = look(counter("n < 3", ""), goal, limits(64, 10'000));
  CHECK(found.result.end == verify::SearchEnd::Found);
  CHECK(found.is_replayed);
  CHECK(found.result.choices.size() >= 20);
}

TEST_CASE("random runs meet an error") {
  verify::SearchGoal goal;
  goal.faults = true;
  const Found found = look(counter("n < 3", "n = n + 0 / (5 - n);"), goal, limits(64, 10'000));
  CHECK(found.result.end == verify::SearchEnd::Found);
  CHECK(found.is_replayed);
  CHECK_FALSE(found.result.fault.empty());
}

TEST_CASE("random runs claim nothing that they do not meet") {
  verify::SearchGoal goal;
  goal.stuck = true;
  // There is none.
  CHECK(look(counter("n == 20", ""), goal, limits(8, 1'000)).result.end == verify::SearchEnd::Limit);
  // It is farther away than the runs go.
  CHECK(look(counter("n < 3", ""), goal, limits(64, 19)).result.end == verify::SearchEnd::Limit);
}

}  // namespace
