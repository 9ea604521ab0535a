// bip::compiler: compile, check, run, explore, verify and draw in one process, with plain data.
#include <catch2/catch.hpp>

#include <algorithm>
#include <string>

#include "compiler/library/include/bip/compiler.hpp"

namespace bc = bip::compiler;

namespace {

// Two takers of two forks, in opposite orders: a deadlock after two steps.
constexpr const char* kTable =
    "package table\n"
    "port type Sync()\n"
    "connector type Both(Sync a, Sync b)\n  define a b\nend\n"
    "atom type Fork()\n"
    "  export port Sync take(), put()\n"
    "  place FREE, TAKEN\n"
    "  initial to FREE\n"
    "  on take from FREE to TAKEN\n"
    "  on put from TAKEN to FREE\n"
    "end\n"
    "atom type Taker()\n"
    "  data int meals\n"
    "  export port Sync first(), second(), done()\n"
    "  place THINKS, HALF, EATS\n"
    "  initial to THINKS do { meals = 0; }\n"
    "  on first from THINKS to HALF\n"
    "  on second from HALF to EATS do { meals = meals + 1; if (meals > 1) then meals = 0; fi }\n"
    "  on done from EATS to THINKS\n"
    "end\n"
    "connector type Three(Sync a, Sync b, Sync c)\n  define a b c\nend\n"
    "compound type Root()\n"
    "  component Fork f(), g()\n"
    "  component Taker t(), u()\n"
    "  connector Both tf(t.first, f.take), tg(t.second, g.take), ug(u.first, g.take), uf(u.second, f.take)\n"
    "  connector Three td(t.done, f.put, g.put), ud(u.done, f.put, g.put)\n"
    "end\n"
    "end\n";

// One component, whose port must fire when its clock is between 2 and 3 s.
constexpr const char* kBeat =
    "package beat\n"
    "port type Sync()\n"
    "connector type One(Sync a)\n  define a\nend\n"
    "atom type Beat()\n"
    "  clock c unit second\n"
    "  export port Sync go()\n"
    "  place P\n"
    "  initial to P\n"
    "  on go from P to P provided (c >= 2 && c <= 3) do { c = 0; }\n"
    "end\n"
    "compound type Root()\n"
    "  component Beat b()\n"
    "  connector One one(b.go)\n"
    "end\n"
    "end\n";

bc::CompileResult interpreted(const char* text) {
  return bc::compile_text(text, {.backend = bc::Backend::Interpreter, .uses_cache = false});
}

}  // namespace

TEST_CASE("errors are data with places", "[library]") {
  const bc::CompileResult result =
      bc::compile_text("package p\ncompound type Root()\n  component Missing m()\nend\nend\n");
  REQUIRE(result.model == nullptr);
  REQUIRE(result.diagnostics.size() == 1);
  const bc::Diagnostic& d = result.diagnostics.front();
  CHECK(d.severity == bc::Severity::Error);
  CHECK(d.code.front() == 'B');
  CHECK(d.file == "model.bip");
  CHECK(d.line == 3);
  CHECK(d.column == 13);
  CHECK(d.end_column == 20);
  CHECK(result.text.find(d.code) != std::string::npos);
  CHECK(bc::compile_file("/nowhere/m.bip").diagnostics.front().line == 0);
  CHECK(bc::check_text(kTable).diagnostics.empty());
}

TEST_CASE("a model runs, and a snapshot repeats the run", "[library]") {
  const bc::CompileResult result = interpreted(kTable);
  INFO(result.text);
  REQUIRE(result.model != nullptr);
  CHECK(result.model->root() == "Root()");
  CHECK(result.model->components() == std::vector<std::string>{"ROOT.f", "ROOT.g", "ROOT.t", "ROOT.u"});
  CHECK(result.model->variables("ROOT.t") == std::vector<std::string>{"ROOT.t.meals"});
  CHECK(result.model->variables("ROOT.x").empty());
  bip::Execution system = result.model->start({.seed = 1});
  CHECK(system.candidate_count() == 2);
  const bip::Execution::Snapshot start = system.snapshot();
  REQUIRE(system.fire(0) == bip::Outcome::Stepped);
  CHECK(system.place("ROOT.t") == "HALF");
  system.restore(start);
  CHECK(system.place("ROOT.t") == "THINKS");
}

TEST_CASE("a deadlock is found by exploration and by proof, with the steps that lead there", "[library]") {
  const bc::CompileResult result = interpreted(kTable);
  REQUIRE(result.model != nullptr);
  const bc::Exploration found = result.model->explore({.threads = 1, .stop = {}});
  REQUIRE(found.is_answered);
  CHECK(found.end == "complete");
  CHECK(found.deadlocks == 1);  // nothing depends on `meals`
  REQUIRE(found.deadlock.has_value());
  REQUIRE(found.deadlock->steps.size() == 2);
  const bc::Verdict verdict = result.model->verify();
  REQUIRE(verdict.is_answered);
  CHECK(verdict.outcome == bc::Outcome::Violated);
  CHECK(verdict.name == "deadlock");
  REQUIRE(verdict.counterexample.has_value());
  // The core takes the same steps again, by number.
  bip::Execution system = result.model->start();
  for (const bc::CounterexampleStep& step : verdict.counterexample->steps) {
    CHECK(system.candidate(step.choice) == step.interaction);
    REQUIRE(system.fire(step.choice) == bip::Outcome::Stepped);
  }
  CHECK(system.candidate_count() == 0);
}

TEST_CASE("a property that holds has a certificate, and a text that is no property is an error", "[library]") {
  const bc::CompileResult result = interpreted(kTable);
  REQUIRE(result.model != nullptr);
  const bc::Verdict holds =
      result.model->verify({.property = "never t@EATS && u@EATS", .wants_certificate = true, .stop = {}});
  REQUIRE(holds.is_answered);
  CHECK(holds.outcome == bc::Outcome::Holds);
  CHECK(holds.property == "never t@EATS && u@EATS");
  CHECK_FALSE(holds.certificate.empty());
  CHECK_FALSE(holds.counterexample.has_value());
  const bc::Verdict none = result.model->verify({.property = "never x@EATS", .stop = {}});
  CHECK_FALSE(none.is_answered);
  CHECK_FALSE(none.problem.empty());
  std::stop_source stop;
  stop.request_stop();
  CHECK(result.model->explore({.threads = 1, .stop = stop.get_token()}).end == "interrupted");
}

TEST_CASE("what is possible has the run that shows it", "[library]") {
  const bc::CompileResult result = interpreted(kTable);
  REQUIRE(result.model != nullptr);
  const bc::Verdict possible = result.model->verify({.property = "possibly t@EATS", .stop = {}});
  REQUIRE(possible.is_answered);
  CHECK(possible.outcome == bc::Outcome::Holds);
  CHECK(possible.method == "run");
  REQUIRE(possible.counterexample.has_value());
  CHECK_FALSE(possible.counterexample->steps.empty());
  // The table has a deadlock.
  const bc::Verdict always = result.model->verify({.property = "always possibly t@EATS", .stop = {}});
  CHECK(always.outcome == bc::Outcome::Violated);
  REQUIRE(always.counterexample.has_value());
  CHECK(result.model->verify({.property = "never possibly t@EATS && t@THINKS", .stop = {}}).method == "branching");
  const bc::Verdict run = result.model->verify({.property = "possibly always !t@EATS", .fairness = "weak", .stop = {}});
  CHECK(run.outcome == bc::Outcome::Holds);
  CHECK(run.counterexample.has_value());
  const bc::Verdict never = result.model->verify({.property = "possibly t@EATS && t@THINKS", .stop = {}});
  CHECK(never.outcome == bc::Outcome::Violated);
  CHECK_FALSE(never.counterexample.has_value());
  const bc::Verdict fair = result.model->verify({.property = "always possibly t@EATS", .fairness = "weak", .stop = {}});
  CHECK_FALSE(fair.is_answered);
  CHECK_FALSE(fair.diagnostics.empty());
}

TEST_CASE("models with clocks", "[library]") {
  const bc::CompileResult result = interpreted(kBeat);
  INFO(result.text);
  REQUIRE(result.model != nullptr);
  bip::Execution system = result.model->start();
  REQUIRE(system.step() == bip::Outcome::Stepped);
  CHECK(system.now() >= 2000000000);
  CHECK(system.now() <= 3000000000);
  const bc::Verdict verdict = result.model->verify();
  INFO(verdict.text);
  CHECK(verdict.is_answered);
}

TEST_CASE("pictures and the system's text", "[library]") {
  const bc::CompileResult result = interpreted(kTable);
  REQUIRE(result.model != nullptr);
  CHECK(result.model->graph().find("digraph bip") != std::string::npos);
  CHECK(result.model->graph(bc::GraphFormat::Json, bc::GraphPart::Structure).front() == '{');
  CHECK(result.model->graph(bc::GraphFormat::Svg).starts_with("<svg "));
  CHECK(result.model->system_text().rfind("(bsys 1)", 0) == 0);
}
