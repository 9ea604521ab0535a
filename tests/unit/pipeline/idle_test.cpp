// What waiting costs: no processor time while clocks or events are pending, and little time from an event to its
// interaction.
#include <catch2/catch.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <memory>
#include <thread>
#include <vector>

#include "compiler/pipeline/pipeline.hpp"
#include "compiler/interp/interp.hpp"

#include "bip/bip.hpp"

using bip::Execution;
using bip::Outcome;
using bip::Posted;
using WallClock = std::chrono::steady_clock;

namespace {

constexpr const char* kIdleModel =
    "package m\n"
    "  port type S()\n  port type N(int n)\n"
    "  connector type One(S p)\n    define p\n  end\n"
    "  atom type Pulse()\n"
    "    clock x unit millisecond\n"
    "    export port S beat()\n"
    "    place P\n    initial to P do { x = 0; }\n"
    "    on beat from P to P provided (x == 250) eager do { x = 0; }\n"
    "  end\n"
    "  atom type Counter()\n"
    "    data int n = 0, count = 0\n"
    "    extern port N add(n) remember\n"
    "    place P\n    initial to P\n"
    "    on add from P to P eager do { count = count + 1; }\n"
    "  end\n"
    "  compound type Pulses()\n    component Pulse a()\n    component Counter c()\n    connector One beat(a.beat)\n  "
    "end\n"
    "  compound type Events()\n    component Counter c()\n  end\n"
    "end\n";

struct IdleModel {
  pipeline::Compilation c;
  std::unique_ptr<bip::interp::Interpreter> interpreter;
  explicit IdleModel(const char* root) : c(pipeline::CompileOptions{.root = root}) {
    c.open_texts["m.bip"] = kIdleModel;
    REQUIRE(pipeline::compile(c, "m.bip", pipeline::Stage::Image));
    interpreter = std::make_unique<bip::interp::Interpreter>(*c.lowered);
  }
  [[nodiscard]] const bip::rt::Image& image() const { return c.lowered->image; }
};

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace

TEST_CASE("who waits for a clock uses no processor time") {
  const IdleModel model("Pulses()");
  Execution system(model.image(), {.seed = 1, .speed = 1});
  const auto started = WallClock::now();
  const double before = cpu_seconds();
  for (int beat = 0; beat < 4; ++beat) REQUIRE(system.step() == Outcome::Stepped);
  const double used = cpu_seconds() - before;
  const std::chrono::duration<double> passed = WallClock::now() - started;
  CHECK(system.now() == 1'000'000'000);
  CHECK(passed.count() >= 0.99);
  // A loop that looked at the clock would use all of it; four steps use some ten microseconds.
  CHECK(used < 0.02 * passed.count());
}

TEST_CASE("from an event to its interaction", "[.timing]") {
  constexpr int kEvents = 2000;
  const IdleModel model("Events()");
  Execution system(model.image(), {.seed = 1, .speed = 1});
  const std::uint32_t port = system.event_port("c.add");
  std::vector<WallClock::time_point> posted(kEvents), taken;
  taken.reserve(kEvents);
  system.on_step([&](const bip::Step&) { taken.push_back(WallClock::now()); });
  std::thread other([&] {
    for (WallClock::time_point& at : posted) {
      // Long enough for the engine to be asleep again.
      std::this_thread::sleep_for(std::chrono::microseconds(300));
      at = WallClock::now();
      CHECK(system.post(port, {1}) == Posted::Taken);
    }
  });
  CHECK(system.run(kEvents) == kEvents);
  other.join();
  REQUIRE(taken.size() == posted.size());
  std::vector<double> us;
  for (std::size_t k = 0; k < taken.size(); ++k)
    us.push_back(std::chrono::duration<double, std::micro>(taken[k] - posted[k]).count());
  std::sort(us.begin(), us.end());
  fmt::print("from post to interaction: median {:.1f} us, 10 % {:.1f}, 90 % {:.1f}, 99 % {:.1f}\n", us[us.size() / 2],
             us[us.size() / 10], us[us.size() * 9 / 10], us[us.size() * 99 / 100]);
  CHECK(us[0] > 0);
}
