// Queries against closed forms: by runs, exactly, by sequential tests and by splitting. Seeds are fixed, so the counts
// are too. The models are those of models/chance.
#include <catch2/catch.hpp>

#include <cmath>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "compiler/interp/interp.hpp"
#include "compiler/library/answer_query.hpp"
#include "compiler/library/markov_chain.hpp"
#include "compiler/library/read_observer.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "runtime/engine/splitting.hpp"

namespace bip::library {
namespace {

/// A model of models/chance, ready to run.
struct Chance {
  pipeline::Compilation c;
  std::unique_ptr<interp::Interpreter> code;

  Chance(const std::string& name, const std::string& root) : c(pipeline::CompileOptions{.root = root}) {
    REQUIRE(compile(c, std::string(BIP_TEST_SOURCE_DIR) + "/models/chance/" + name, pipeline::Stage::Image));
    code = std::make_unique<interp::Interpreter>(*c.lowered);
  }
  [[nodiscard]] Query query(const std::string& text) const {
    Result<Query> query = read_query(text, *c.system);
    INFO(text);
    REQUIRE(query);
    return std::move(*query);
  }
  [[nodiscard]] const rt::Image& image() const { return c.lowered->image; }
};

struct Asked {
  const char* model;
  const char* root;
  const char* query;
  double value;
};
const double kRatio = 7.0 / 3.0;
const Asked kAsked[] = {
    {"dice.bip", "Root()", "P=? [ F die@D1 ]", 1.0 / 6},
    {"dice.bip", "Root()", "P=? [ F<=3 die.side >= 4 ]", 3.0 / 8},
    {"ruin.bip", "Root()", "P=? [ F gambler.fortune == 7 ]", 7.0 / 127},
    {"ruin.bip", "Game(2, 5, 1.0, 1.0)", "P=? [ F gambler.fortune == 5 ]", 0.4},
    {"retry.bip", "Root()", "P=? [ F<=2 sender@DONE ]", 0.99},
    {"retry.bip", "Root()", "P=? [ G{1} sender@SENDS ]", 0.1},
    {"queue.bip", "Root()", "P=? [ shop.line.length > 0 U shop.line.length == 6 ]", 0.5 / (std::pow(1.5, 6) - 1)},
    {"token_loss.bip", "Root()", "P=? [ F ring.head@DONE ]", std::pow(0.98, 10)},
    {"craps.bip", "Root()", "P=? [ F player.outcome == 1 ]", 244.0 / 495},
    {"craps.bip", "Root()", "P=? [ F<=1 player.outcome == 2 ]", 1.0 / 9},
};
// Of models with time, which have no chain.
const Asked kAskedInTime[] = {
    {"mm1.bip", "Root()", "P=? [ shop.line.length < 2 U shop.line.length == 0 ]", 2.0 / 3},
    {"mm1.bip", "Queue(1.0, 1.0, 1)", "P=? [ line.length < 2 U line.length == 0 ]", 0.5},
};

Interval exactly(const Chance& model, const Query& query) {
  const auto always = [](const rt::Core&) { return true; };
  std::vector<StateSet> sets;
  const Result<MarkovChain> chain = build_chain(
      model.image(), rt::MaximalProgress::On, 100'000,
      {query.path.stays ? query.path.stays : std::function<bool(const rt::Core&)>(always), query.path.goal}, sets);
  REQUIRE(chain);
  Interval value = reach_probability(*chain, sets[0], sets[1], query.path.most_steps);
  if (query.path.is_negated) value = {1 - value.high, 1 - value.low};
  return value;
}

}  // namespace

TEST_CASE("the chain's probabilities are the closed forms") {
  for (const Asked& asked : kAsked) {
    INFO(asked.model << ": " << asked.query);
    const Chance model(asked.model, asked.root);
    const Interval value = exactly(model, model.query(asked.query));
    CHECK(value.low <= asked.value + 1e-12);
    CHECK(value.high >= asked.value - 1e-12);
    CHECK(value.high - value.low <= kPrecision * value.high + 1e-15);
  }
}

TEST_CASE("a rare probability is as exact as a usual one") {
  const Chance model("ruin.bip", "Game(1, 25, 3.0, 7.0)");
  const double truth = (kRatio - 1) / (std::pow(kRatio, 25) - 1);
  const Interval value = exactly(model, model.query("P=? [ F gambler.fortune == 25 ]"));
  CHECK(value.low <= truth * (1 + 1e-9));
  CHECK(value.high >= truth * (1 - 1e-9));
  CHECK(value.high - value.low <= 1e-9 * truth);
}

TEST_CASE("expected steps") {
  const auto expected = [](const char* name, const char* root, const char* text) {
    const Chance model(name, root);
    const Query query = model.query(text);
    std::vector<StateSet> sets;
    const Result<MarkovChain> chain =
        build_chain(model.image(), rt::MaximalProgress::On, 100'000,
                    {[&](const rt::Core& core) { return query.observer.value(core) != 0; }}, sets);
    REQUIRE(chain);
    return expected_steps(*chain, sets[0]);
  };
  CHECK(expected("dice.bip", "Root()", "E=? [ time until die.side > 0 ]") == Approx(11.0 / 3).epsilon(1e-9));
  CHECK(expected("retry.bip", "Root()", "E=? [ time until sender@DONE ]") == Approx(10.0 / 9).epsilon(1e-9));
  CHECK(expected("craps.bip", "Root()", "E=? [ time until player.outcome != 0 ]") == Approx(557.0 / 165).epsilon(1e-9));
  // A fair game from 3 of 10 ends after 3 * 7 rounds.
  CHECK(expected("ruin.bip", "Game(3, 10, 1.0, 1.0)",
                 "E=? [ time until gambler.fortune == 0 || gambler.fortune == 10 ]") == Approx(21).epsilon(1e-9));
  CHECK(std::isinf(expected("ruin.bip", "Game(3, 10, 1.0, 1.0)", "E=? [ time until gambler.fortune == 10 ]")));
}

TEST_CASE("estimates hold closed forms as often as their intervals say") {
  constexpr std::uint64_t kEstimates = 1000, kRuns = 200;
  std::vector<Asked> all_asked(std::begin(kAsked), std::end(kAsked));
  all_asked.insert(all_asked.end(), std::begin(kAskedInTime), std::end(kAskedInTime));
  for (const Asked& asked : all_asked) {
    INFO(asked.model << ": " << asked.query);
    const Chance model(asked.model, asked.root);
    rt::SimulateOptions options{.runs = kEstimates * kRuns, .seed = 1, .threads = 2};
    options.queries.push_back(model.query(asked.query).path);
    const rt::SimulateReport report = rt::simulate(model.image(), options);
    REQUIRE(report.is_complete);
    std::uint64_t holding = 0, all = 0;
    for (std::uint64_t k = 0; k < kEstimates; ++k) {
      std::uint64_t successes = 0;
      for (std::uint64_t run = k * kRuns; run < (k + 1) * kRuns; ++run) {
        REQUIRE(report.answers[0][run] != rt::Answer::Open);
        successes += report.answers[0][run] == rt::Answer::Yes ? 1 : 0;
      }
      const Interval interval = clopper_pearson(successes, kRuns, 0.99);
      holding += interval.low <= asked.value && asked.value <= interval.high ? 1 : 0;
      all += successes;
    }
    CHECK(holding >= 985);
    // All of them together are an estimate, too: within 4 of its deviations.
    const double runs = kEstimates * kRuns, deviation = std::sqrt(asked.value * (1 - asked.value) / runs);
    CHECK(std::fabs(static_cast<double>(all) / runs - asked.value) < 4 * deviation);
  }
}

TEST_CASE("a queue is empty again after the time that theory says") {
  const Chance model("mm1.bip", "Root()");
  constexpr std::uint64_t kRuns = 60'000;
  rt::SimulateOptions options{.runs = kRuns, .seed = 1, .threads = 2};
  options.limit = 1'000'000;
  options.observers.push_back(*read_observer("time until shop.line.length == 0", *model.c.system));
  const auto empty = read_observer("last shop.line.length", *model.c.system)->value;
  options.stop = [&](const rt::Core& core) { return empty(core) == 0; };
  const rt::SimulateReport report = rt::simulate(model.image(), options);
  double sum = 0;
  for (const double value : report.values[0]) sum += value;
  // Mean 1 / (1 - 1/2) seconds, variance (1 + rho) / (1 - rho)^3 with rho = 1/2.
  CHECK(std::fabs(sum / kRuns - 2) < 4 * std::sqrt(12.0 / kRuns));
}

TEST_CASE("sequential tests err as seldom as they say") {
  const Chance model("ruin.bip", "Game(2, 5, 1.0, 1.0)");
  const auto denials = [&](const char* text) {
    const Query query = model.query(text);
    int denied = 0;
    for (std::uint64_t k = 0; k < 200; ++k) {
      const TestRun found = test_query(query, model.image(), {.runs = 100'000, .seed = 1 + k * 100'000},
                                       {.alpha = 0.05, .beta = 0.05, .delta = 0.1});
      REQUIRE(found.answer.verdict != QueryVerdict::Unknown);
      denied += found.answer.verdict == QueryVerdict::Violated ? 1 : 0;
    }
    return denied;
  };
  // 0.4 is at an end of the region of indifference: 10 errors of 200 are expected at most, more than 22 once in 10,000.
  CHECK(denials("P>=0.3 [ F gambler.fortune == 5 ]") <= 22);
  CHECK(denials("P>=0.5 [ F gambler.fortune == 5 ]") >= 178);
  CHECK(denials("P<=0.5 [ F gambler.fortune == 5 ]") <= 22);
}

TEST_CASE("tests do not depend on the number of threads") {
  const Chance model("retry.bip", "Root()");
  const Query query = model.query("P>=0.85 [ F<=1 sender@DONE ]");
  const TestRun one = test_query(query, model.image(), {.runs = 100'000, .seed = 7, .threads = 1}, {});
  const TestRun three = test_query(query, model.image(), {.runs = 100'000, .seed = 7, .threads = 3}, {});
  CHECK(one.answer.verdict == QueryVerdict::Holds);
  CHECK(one.answer.runs == three.answer.runs);
  CHECK(one.answer.successes == three.answer.successes);
}

TEST_CASE("splitting is unbiased for good and bad levels") {
  const Chance model("ruin.bip", "Game(1, 10, 3.0, 7.0)");
  const double truth = (kRatio - 1) / (std::pow(kRatio, 10) - 1);
  Result<std::function<double(const rt::Core&)>> importance = read_number("gambler.fortune", *model.c.system);
  REQUIRE(importance);
  rt::SplittingOptions options{.query = model.query("P=? [ F gambler.fortune == 10 ]").path,
                               .importance = *importance,
                               .levels = {},
                               .effort = 500,
                               .replications = 64,
                               .seed = 3,
                               .threads = 2,
                               .is_stopped = {}};
  for (const std::vector<double>& levels :
       {std::vector<double>{}, std::vector<double>{2, 3, 4, 5, 6, 7, 8, 9}, std::vector<double>{4, 8}}) {
    options.levels = levels;
    const rt::SplittingReport found = rt::split(model.image(), options);
    REQUIRE(found.is_complete);
    const Estimate of = estimate(found.estimates, {}, 0.9999);
    CHECK(of.mean_interval.low <= truth);
    CHECK(truth <= of.mean_interval.high);
    if (levels.size() != 2) continue;
    options.threads = 3;
    CHECK(rt::split(model.image(), options).estimates == found.estimates);
  }
}

TEST_CASE("an event of probability 1e-9 is estimated within a fifth") {
  const Chance model("ruin.bip", "Game(1, 25, 3.0, 7.0)");
  const double truth = (kRatio - 1) / (std::pow(kRatio, 25) - 1);
  Result<std::function<double(const rt::Core&)>> importance = read_number("gambler.fortune", *model.c.system);
  REQUIRE(importance);
  rt::SplittingOptions options{.query = model.query("P=? [ F gambler.fortune == 25 ]").path,
                               .importance = *importance,
                               .levels = {},
                               .effort = 500,
                               .replications = 32,
                               .seed = 1,
                               .threads = 2,
                               .is_stopped = {}};
  const rt::SplittingReport one = rt::split(model.image(), options);
  REQUIRE(one.is_complete);
  const Estimate of = estimate(one.estimates, {}, 0.95);
  CHECK(of.mean == Approx(truth).epsilon(0.2));
}

}  // namespace bip::library
