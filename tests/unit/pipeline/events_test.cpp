// Events from outside while a model runs: threads that post, back-pressure, waiting without work, snapshots.
#include <catch2/catch.hpp>

#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <ctime>
#include <memory>
#include <thread>

#include "compiler/pipeline/pipeline.hpp"
#include "compiler/interp/interp.hpp"

#include "bip/bip.hpp"

using bip::Execution;
using bip::Outcome;
using bip::Posted;
namespace interp = bip::interp;
namespace rt = bip::rt;

namespace {

constexpr const char* kCounter =
    "package m\n"
    "  port type N(int n)\n"
    "  atom type Counter()\n"
    "    data int n = 0, count = 0\n    data float sum = 0\n"
    "    extern port N add(n) remember\n"
    "    place P\n    initial to P\n"
    "    on add from P to P eager do { count = count + 1; sum = sum + n; }\n"
    "  end\n"
    "  atom type Lamp()\n"
    "    clock x\n    data int n = 0\n"
    "    extern port N on_(n) ignore\n"
    "    place OFF, LIT\n    initial to OFF\n"
    "    on on_ from OFF to LIT eager do { x = 0; }\n"
    "    internal from LIT to OFF provided (n < 0)\n"
    "  end\n"
    "  compound type R()\n    component Counter c()\n    component Lamp l()\n  end\n"
    "end\n";

struct EventModel {
  pipeline::Compilation c{pipeline::CompileOptions{}};
  std::unique_ptr<interp::Interpreter> interpreter;
  explicit EventModel(const char* text) {
    c.open_texts["m.bip"] = text;
    REQUIRE(pipeline::compile(c, "m.bip", pipeline::Stage::Image));
    interpreter = std::make_unique<interp::Interpreter>(*c.lowered);
  }
  [[nodiscard]] const rt::Image& image() const { return c.lowered->image; }
};

std::int32_t count_of(const Execution& system) {
  std::int32_t count = -1;
  REQUIRE(system.read("ROOT.c.count", count));
  return count;
}

}  // namespace

TEST_CASE("in logical time an event comes at the next step") {
  const EventModel model(kCounter);
  Execution system(model.image(), {.seed = 1});
  CHECK(system.step() == Outcome::Deadlock);
  CHECK(system.post("c.add", {7}) == Posted::Taken);
  CHECK(system.post("ROOT.c.add", {true}) == Posted::BadValues);
  CHECK(system.post("c.add") == Posted::BadValues);
  CHECK(system.post("c.sub", {7}) == Posted::NoSuchPort);
  CHECK(system.step() == Outcome::Stepped);
  CHECK(system.step() == Outcome::Deadlock);
  CHECK(count_of(system) == 1);
}

TEST_CASE("a full queue is told, and is free again once the model takes") {
  const EventModel model(kCounter);
  Execution system(model.image(), {.seed = 1, .event_capacity = 3});
  for (int k = 0; k < 3; ++k) CHECK(system.post("c.add", {k}) == Posted::Taken);
  CHECK(system.post("c.add", {3}) == Posted::Full);
  CHECK(system.post("l.on_", {3}) == Posted::Taken);
  // Two are taken in order; the third still waits in the core.
  CHECK(system.run(3) == 3);
  CHECK(system.step() == Outcome::Stepped);
  CHECK(system.step() == Outcome::Deadlock);
  for (int k = 0; k < 3; ++k) CHECK(system.post("c.add", {k}) == Posted::Taken);
  CHECK(system.post("c.add", {3}) == Posted::Full);
  CHECK(system.run(10) == 3);
  CHECK(count_of(system) == 6);
}

TEST_CASE("a snapshot holds the events that wait") {
  const EventModel model(kCounter);
  Execution system(model.image(), {.seed = 1});
  for (int k = 1; k <= 4; ++k) REQUIRE(system.post("c.add", {k}) == Posted::Taken);
  REQUIRE(system.step() == Outcome::Stepped);
  const Execution::Snapshot snapshot = system.snapshot();
  CHECK(system.run(10) == 3);
  system.restore(snapshot);
  CHECK(count_of(system) == 1);
  CHECK(system.run(10) == 3);
  double sum = 0;
  REQUIRE(system.read("ROOT.c.sum", sum));
  CHECK(sum == 10);
}

TEST_CASE("events that wait in a restored state count for the queue's bound") {
  const EventModel model(kCounter);
  Execution system(model.image(), {.seed = 1, .event_capacity = 3});
  for (int k = 0; k < 3; ++k) REQUIRE(system.post("c.add", {k}) == Posted::Taken);
  REQUIRE(system.step() == Outcome::Stepped);
  const Execution::Snapshot two_wait = system.snapshot();
  CHECK(system.run(10) == 2);
  const Execution::Snapshot none_waits = system.snapshot();
  system.restore(two_wait);
  CHECK(system.post("c.add", {3}) == Posted::Taken);
  CHECK(system.post("c.add", {4}) == Posted::Full);
  CHECK(system.run(10) == 3);
  system.restore(two_wait);
  system.restore(none_waits);
  for (int k = 0; k < 3; ++k) CHECK(system.post("c.add", {k}) == Posted::Taken);
  CHECK(system.post("c.add", {4}) == Posted::Full);
}

TEST_CASE("eight threads post, and nothing that was taken in is lost") {
  const EventModel model(kCounter);
  Execution system(model.image(), {.seed = 1, .speed = 1, .event_capacity = 64});
  constexpr int kThreads = 8, kEach = 2000;
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&system] {
      const std::uint32_t port = system.event_port("c.add");
      for (int k = 0; k < kEach;) {
        if (system.post(port, {1}) == Posted::Taken) ++k;
        else std::this_thread::yield();
      }
    });
  }
  CHECK(system.run(kThreads * kEach) == kThreads * kEach);
  for (std::thread& thread : threads) thread.join();
  CHECK(count_of(system) == kThreads * kEach);
}

TEST_CASE("who waits for events sleeps, and stop ends it") {
  const EventModel model(kCounter);
  Execution system(model.image(), {.seed = 1, .speed = 1});
  // Catch2's CHECK is for one thread.
  std::clock_t used = 0;
  Posted posted = Posted::Full;
  std::atomic<bool> has_stepped{false};
  std::thread other([&] {
    const std::clock_t before = std::clock();
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    used = std::clock() - before;
    posted = system.post("c.add", {1});
    for (int k = 0; k < 60000 && !has_stepped; ++k) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    system.stop();
  });
  CHECK(system.step() == Outcome::Stepped);
  has_stepped = true;
  CHECK(system.now() >= 250'000'000);
  CHECK(system.step() == Outcome::Stopped);
  other.join();
  CHECK(posted == Posted::Taken);
  // Of the whole process, in 300 ms: nobody polls.
  CHECK(used < CLOCKS_PER_SEC / 50);
}
