// The threaded engine: actions overlap, what meets does not; runs are sequential ones, faults and all; and binary
// traces, with which that is told.
#include <catch2/catch.hpp>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <thread>

#include "runtime/engine/replay_record.hpp"
#include "tests/unit/base/contents.hpp"
#include "tests/unit/runtime/helpers.hpp"
#include "tests/unit/runtime/models.hpp"

using namespace bip::rt;
using namespace bip::rt::testing;
using bip::testing::contents;

namespace {

struct Recorded {
  RunResult result;
  std::string trace, out, err;
};
Recorded recorded(const Image& image, std::uint64_t seed, std::uint64_t limit, Engine engine, std::uint64_t perturb) {
  RunOptions options;
  options.seed = seed;
  options.has_seed = true;
  options.limit = limit;
  options.engine = engine;
  options.threads = 3;
  options.perturb = perturb;
  options.format = TraceFormat::Binary;
  std::FILE* out = std::tmpfile();
  std::FILE* err = std::tmpfile();
  std::FILE* trace = std::tmpfile();
  options.trace_path = "/proc/self/fd/" + std::to_string(fileno(trace));
  Recorded result{run(image, options, out, err), "", "", ""};
  result.trace = contents(trace);
  result.out = contents(out);
  result.err = contents(err);
  return result;
}
Followed followed(const Image& image, std::string_view trace, std::string* text = nullptr) {
  std::FILE* out = std::tmpfile();
  Followed result = follow(image, trace, {}, out);
  const std::string lines = contents(out);
  if (text != nullptr) *text = lines;
  return result;
}

// `count` atoms that never meet; each step of one calls `action`.
void build_workers(ImageBuilder& b, int count, const Fn& action) {
  b.atom_type({.name = "Worker",
               .data = {"n"},
               .ports = {{.name = "go"}},
               .places = {"S"},
               .initial = {"S"},
               .transitions = {{.port = "go", .from = {"S"}, .to = {"S"}, .action = action}}});
  b.connector_type({.name = "One", .params = {{"p", 0}}, .define = "p"});
  for (int i = 0; i < count; ++i) {
    const std::string name = "w[" + std::to_string(i) + "]";
    b.atom(name, "Worker");
    b.connector("go[" + std::to_string(i) + "]", "One", {name + ".go"});
  }
}

}  // namespace

TEST_CASE("actions of atoms that do not meet overlap") {
  std::atomic<int> inside{0}, most{0};
  ImageBuilder b;
  build_workers(b, 4, [&](Cell*, Cell*, const u32*) {
    const int now = ++inside;
    for (int seen = most; seen < now && !most.compare_exchange_weak(seen, now);) {
    }
    // Long enough for another thread to come, however busy the machine is; it does not last if one does.
    for (int i = 0; i < 2000 && most < 2; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    --inside;
    return 1;
  });
  CHECK(recorded(b.image(), 1, 8, Engine::Threads, 0).result.end == End::Limit);
  CHECK(most >= 2);
}

TEST_CASE("an atom is never in two actions at once") {
  std::atomic<int> clashes{0};
  ImageBuilder b;
  build_workers(b, 3, [&](Cell* self, Cell*, const u32*) {
    // Not atomic on purpose: TSan tells of any overlap, and so does the count.
    const std::int32_t before = self[0].i;
    std::this_thread::yield();
    if (self[0].i != before) ++clashes;
    self[0].i = before + 1;
    return 1;
  });
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Recorded run = recorded(b.image(), seed, 200, Engine::Threads, seed);
    CHECK(run.result.steps == 200);
    const Followed check = followed(b.image(), run.trace);
    CHECK(check.problem.empty());
    CHECK(check.steps == 200);
  }
  CHECK(clashes == 0);
}

TEST_CASE("runs of philosophers are accepted, the deadlock too") {
  for (const bool deadlocks : {false, true}) {
    ImageBuilder b;
    build_philosophers(b, 5, deadlocks);
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const Recorded run = recorded(b.image(), seed, 300, Engine::Threads, seed);
      std::string lines;
      const Followed check = followed(b.image(), run.trace, &lines);
      INFO(check.problem);
      CHECK(check.problem.empty());
      CHECK(check.end == run.result.end);
      // What the threads printed is what a sequential run prints.
      CHECK(lines.substr(0, lines.find("deadlock")) == run.out.substr(0, run.out.find("deadlock")));
    }
  }
}

TEST_CASE("a fault ends the run at the step where a sequential one meets it") {
  // The fifth step of each atom faults; the others are slower or faster as it comes.
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    ImageBuilder b;
    build_workers(b, 3, [](Cell* self, Cell*, const u32*) {
      return ++self[0].i == 5 ? fault_status(0, FaultKind::DivisionByZero) : 1;
    });
    const Recorded run = recorded(b.image(), seed, 1000, Engine::Threads, seed);
    CHECK(run.result.end == End::Fault);
    CHECK(run.result.exit_code == 1);
    CHECK(run.err.find("R0005") != std::string::npos);
    const Followed check = followed(b.image(), run.trace);
    INFO(check.problem);
    CHECK(check.problem.empty());
    CHECK(check.end == End::Fault);
    CHECK(check.steps == run.result.steps);
  }
}

TEST_CASE("a connector's fault ends the run at the step where a sequential one meets it") {
  // When one of two atoms is a step ahead; they could step at a time and never be seen so.
  const Fn fault = [](Cell*, Cell* all, const u32* bind) {
    return all[bind[0]].i + all[bind[1]].i == 1 ? fault_status(0, FaultKind::DivisionByZero) : 0;
  };
  const Fn pass = [](Cell* self, Cell* all, const u32* bind) { return self[0].i = all[bind[0]].i, 1; };
  for (const char* where : {"guard", "up", "guard above"}) {
    INFO(where);
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      ImageBuilder b;
      b.atom_type({.name = "Worker",
                   .data = {"n"},
                   .ports = {{.name = "go"}, {.name = "look", .vars = {"n"}}},
                   .places = {"S"},
                   .initial = {"S"},
                   .transitions = {{.port = "go",
                                    .from = {"S"},
                                    .to = {"S"},
                                    .action = [](Cell* self, Cell*, const u32*) { return ++self[0].i, 1; }},
                                   {.port = "look", .from = {"S"}, .to = {"S"}}}});
      b.connector_type({.name = "One", .params = {{"p", 0}}, .define = "p"});
      b.connector_type({.name = "Pass",
                        .params = {{"p", 1}},
                        .define = "p",
                        .clauses = {{.params = {"p"}, .up = pass}},
                        .data = {"n"},
                        .exports = true,
                        .exported_data = {"n"}});
      const bool is_up = std::string_view(where) == "up", is_above = std::string_view(where) == "guard above";
      b.connector_type({.name = "Both",
                        .params = {{"p", 1}, {"q", 1}},
                        .define = "p q",
                        .clauses = {{.params = {"p", "q"},
                                     .guard = is_up ? nullptr : fault,
                                     .up = is_up ? fault : nullptr,
                                     .may_fault = true}}});
      for (const std::string name : {"v", "w"}) {
        b.atom(name, "Worker");
        b.connector("go_" + name, "One", {name + ".go"});
      }
      if (is_above) b.connector("pass", "Pass", {"v.look"});
      b.connector("both", "Both", {is_above ? "pass" : "v.look", "w.look"});
      const Recorded run = recorded(b.image(), seed, 100, Engine::Threads, seed);
      CHECK(run.result.end == End::Fault);
      const Followed check = followed(b.image(), run.trace);
      INFO(check.problem);
      CHECK(check.problem.empty());
      CHECK(check.end == End::Fault);
      CHECK(check.steps == run.result.steps);
    }
  }
}

TEST_CASE("a trace that is no run is refused") {
  ImageBuilder b;
  build_philosophers(b, 3, true);
  const Recorded run = recorded(b.image(), 7, 50, Engine::Sequential, 0);
  REQUIRE(followed(b.image(), run.trace).problem.empty());
  SECTION("another step") {
    // Every single change of a step's byte: another interaction is no candidate there, or leads elsewhere.
    const std::size_t first = run.trace.find("Test") + 4;
    for (std::size_t at = first; at + 10 < run.trace.size(); ++at) {
      std::string wrong = run.trace;
      wrong[at] = static_cast<char>(wrong[at] + 2);
      INFO(at);
      CHECK_FALSE(followed(b.image(), wrong).problem.empty());
    }
  }
  SECTION("cut off") {
    CHECK(followed(b.image(), std::string_view(run.trace).substr(0, run.trace.size() - 9)).problem.find("cut off") !=
          std::string::npos);
  }
  SECTION("no trace") {
    const Followed check = followed(b.image(), "[BIP ENGINE]: state #0");
    CHECK_FALSE(check.is_trace);
  }
  SECTION("another root") {
    ImageBuilder other;
    build_ring(other, 3);
    const Followed check = followed(other.image(), run.trace);
    CHECK_FALSE(check.problem.empty());
  }
}
