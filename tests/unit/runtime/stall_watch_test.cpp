// A node that stands still stops its robot, and lets it go on when steps end again.
#include <catch2/catch.hpp>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <string>
#include <thread>

#include <unistd.h>

#include "runtime/engine/stall_watch.hpp"

using namespace bip::rt;

namespace {

// The functions of a watch are C functions: they have no object of their own.
std::atomic<int> robot_stops{0}, robot_starts{0};
std::atomic<bool> has_run_ended{false}, is_reason_odd{false};

// However slow the machine is: only what never comes fails.
template <class Condition>
bool comes_true(const Condition& condition) {
  using namespace std::chrono;
  const auto end = steady_clock::now() + seconds(60);
  while (!condition() && steady_clock::now() < end) std::this_thread::sleep_for(milliseconds(1));
  return condition();
}

}  // namespace

TEST_CASE("a node that stands still stops the robot once, until steps end again, and at the end") {
  for (const bool can_go_on : {true, false}) {
    robot_stops = robot_starts = 0;
    has_run_ended = is_reason_odd = false;
    StallOptions options;
    options.after = 10'000'000;
    options.stop_name = "brake";
    options.stop = [](const char* why) {
      const std::string text = why;
      has_run_ended = text == "the run has ended";
      if (!has_run_ended && text.find("no step has ended for ") != 0) is_reason_odd = true;
      ++robot_stops;
    };
    if (can_go_on) {
      options.go_on = [](const char* why) {
        if (std::string(why).find("steps end again after ") != 0) is_reason_odd = true;
        ++robot_starts;
      };
    }
    {
      StallWatch watch(options, "field");
      REQUIRE(watch.start());
      CHECK(comes_true([] { return robot_stops == 1; }));
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      CHECK(robot_stops == 1);
      CHECK(robot_starts == 0);
      watch.note_steps();
      // It stands still again.
      CHECK(comes_true([] { return robot_stops == 2; }));
      CHECK(robot_starts == (can_go_on ? 1 : 0));
      CHECK_FALSE(has_run_ended);
    }
    CHECK(has_run_ended);
    CHECK(robot_stops == 3);
    CHECK_FALSE(is_reason_odd);
  }
}

TEST_CASE("a stall is reported also if nothing stops the robot") {
  StallOptions options;
  options.after = 10'000'000;
  std::atomic<bool> goes_on{false};
  std::FILE* const said = std::tmpfile();
  REQUIRE(said != nullptr);
  std::fflush(stderr);
  const int before = dup(STDERR_FILENO);
  REQUIRE(dup2(fileno(said), STDERR_FILENO) >= 0);
  const auto has_said = [said](const char* what) {
    std::string text(4096, '\0');
    const ssize_t size = pread(fileno(said), text.data(), text.size(), 0);
    return size > 0 && text.substr(0, static_cast<std::size_t>(size)).find(what) != std::string::npos;
  };
  {
    StallWatch watch(options, "field");
    const bool starts = watch.start();
    const bool stalls = starts && comes_true([&] { return has_said("node `field`: no step has ended for "); });
    watch.note_steps();
    goes_on = stalls && comes_true([&] { return has_said("node `field`: steps end again after "); });
  }
  dup2(before, STDERR_FILENO);
  close(before);
  CHECK(goes_on);
  CHECK_FALSE(has_said("was called"));
  std::fclose(said);
}
