// `simulate` against closed forms: of 1,000 estimates the intervals of 99% hold the true value about 990 times. Seeds
// are fixed, so the counts are too.
#include <catch2/catch.hpp>

#include <memory>
#include <string>

#include "compiler/library/estimate.hpp"
#include "compiler/library/read_observer.hpp"
#include "compiler/interp/interp.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "runtime/engine/simulate.hpp"

namespace bip::library {
namespace {

constexpr std::uint64_t kEstimates = 1000, kRuns = 200;
constexpr double kLevel = 0.99;

struct ClosedForm {
  const char* name;
  const char* atom;      // the declaration of atom type A
  const char* bindings;  // connectors of its instance `a`
  const char* observer;
  double value;
};

const ClosedForm kForms[] = {
    // From 3 of 10 a fair game reaches 10 before 0 with probability 3/10.
    {"gambler's ruin",
     "data int x = 3\n export port S win(), lose()\n place P\n initial to P\n "
     "on win from P to P provided (x > 0 && x < 10) do { x = x + 1; } "
     "on lose from P to P provided (x > 0 && x < 10) do { x = x - 1; }",
     "win(a.win), lose(a.lose)", "reaches a.x == 10", 0.3},
    // One of five, until it comes: 5 steps.
    {"a geometric number",
     "export port S hit(), b(), c(), d(), e() place P, Q initial to P final Q on hit from P to Q "
     "on b from P to P on c from P to P on d from P to P on e from P to P",
     "hit(a.hit), b(a.b), c(a.c), d(a.d), e(a.e)", "time until a@Q", 5},
    // Heads of 20 tosses.
    {"a binomial number",
     "data int n = 0 export port S heads(), tails() place P initial to P "
     "on heads from P to P provided (n < 20) do { n = n + 1; } on tails from P to P provided (n < 20) do { n = n + 1; "
     "}",
     "heads(a.heads), tails(a.tails)", "count a.heads", 10},
    // All of four coupons: 4 (1 + 1/2 + 1/3 + 1/4).
    {"the coupon collector",
     "data int a = 0, b = 0, c = 0, d = 0 export port S pa(), pb(), pc(), pd() place P initial to P "
     "on pa from P to P do { a = 1; } on pb from P to P do { b = 1; } "
     "on pc from P to P do { c = 1; } on pd from P to P do { d = 1; }",
     "pa(a.pa), pb(a.pb), pc(a.pc), pd(a.pd)", "time until a.a + a.b + a.c + a.d == 4", 4.0 * 25 / 12},
    // Uniform between 1 s and 3 s.
    {"a uniform instant",
     "clock x unit second export port S p() place P, Q initial to P final Q "
     "on p from P to Q provided (x >= 1 && x <= 3) delayable",
     "p(a.p)", "time until a@Q", 2},
    // Exponential with mean 1 s after 1 s: its time in P.
    {"an exponential duration",
     "clock x unit second export port S p() place P, Q initial to P final Q on p from P to Q provided (x >= 1)",
     "p(a.p)", "duration of a@P", 2},
    // Delays that are drawn: around 2 s; exponential with mean 2 s; and data.
    {"a truncated normal delay",
     "clock x data float d = normal(2.0, 0.5, 1.0, 3.0) export port S p() place P, Q initial to P final Q "
     "on p from P to Q provided (x == d) eager",
     "p(a.p)", "time until a@Q", 2},
    {"an exponential delay",
     "clock x data float d = exponential(2.0) export port S p() place P, Q initial to P final Q "
     "on p from P to Q provided (x == d) eager",
     "p(a.p)", "time until a@Q", 2},
    {"numbers of a table",
     "data int n = 0, k = 0 export port S p() place P initial to P "
     "on p from P to P provided (k < 10) do { k = k + 1; n = n + table(1, 0.5, 2, 0.3, 10, 0.2); }",
     "p(a.p)", "last a.n", 31},
};

std::string text_of(const ClosedForm& form) {
  return std::string(
             "package m\n  use std.chance\n  port type S()\n  connector type One(S p) define p end\n  atom type A()\n  "
             "  ") +
         form.atom + "\n  end\n  compound type Root()\n    component A a()\n    connector One " + form.bindings +
         "\n  end\nend\n";
}

}  // namespace

TEST_CASE("intervals hold closed forms as often as they say") {
  for (const ClosedForm& form : kForms) {
    INFO(form.name);
    pipeline::Compilation c{pipeline::CompileOptions{.root = "Root()"}};
    c.open_texts["m.bip"] = text_of(form);
    REQUIRE(compile(c, "m.bip", pipeline::Stage::Image));
    const interp::Interpreter code(*c.lowered);
    Result<rt::Observer> observer = read_observer(form.observer, *c.system);
    REQUIRE(observer);
    const bool is_probability = observer->kind == rt::ObserverKind::Reaches;
    rt::SimulateOptions options{.runs = kEstimates * kRuns, .seed = 1, .threads = 2};
    options.observers.push_back(std::move(*observer));
    const rt::SimulateReport report = rt::simulate(c.lowered->image, options);
    REQUIRE(report.is_complete);
    std::uint64_t holding = 0;
    for (std::uint64_t k = 0; k < kEstimates; ++k) {
      const auto first = report.values[0].begin() + static_cast<std::ptrdiff_t>(k * kRuns);
      const std::vector<double> values(first, first + kRuns);
      const Estimate of = estimate(values, {}, kLevel);
      REQUIRE(of.count == kRuns);
      const auto successes = static_cast<std::uint64_t>(std::llround(of.mean * kRuns));
      const Interval interval = is_probability ? clopper_pearson(successes, kRuns, kLevel) : of.mean_interval;
      holding += interval.low <= form.value && form.value <= interval.high ? 1 : 0;
    }
    CHECK(holding >= 985);
    CHECK(holding < kEstimates);
  }
}

}  // namespace bip::library
