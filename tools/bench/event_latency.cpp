// Events into a running model (tools/bench/time): how long from post() to the step that takes it, and how many a second
// from eight threads.
//
//   events SINGLES TOTAL      both are counts of events; the model is in tools/bench/time
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

#include "bip/bip.hpp"

namespace model {
const bip::rt::Image& image();
}

namespace {

using Clock = std::chrono::steady_clock;
double micros(Clock::duration d) { return std::chrono::duration<double, std::micro>(d).count(); }

// One at a time, the engine asleep in between.
void latency(int count) {
  bip::Execution system(model::image(), {.seed = 1, .policy = bip::rt::Policy::First, .speed = 1});
  std::vector<double> took;
  std::atomic<std::int64_t> posted{0};
  system.on_step([&](const bip::Step&) {
    took.push_back(micros(Clock::now() - Clock::time_point(Clock::duration(posted.load()))));
  });
  std::thread poster([&] {
    const std::uint32_t port = system.event_port("sink.take");
    for (int k = 0; k < count; ++k) {
      std::this_thread::sleep_for(std::chrono::microseconds(300));
      posted = Clock::now().time_since_epoch().count();
      (void)system.post(port, {k});
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    system.stop();
  });
  while (system.step() == bip::Outcome::Stepped) {
  }
  poster.join();
  std::sort(took.begin(), took.end());
  if (took.empty()) return;
  std::printf("post to step: median %.1f us, 99 %% below %.1f us, most %.1f us (%zu of %d events)\n",
              took[took.size() / 2], took[took.size() * 99 / 100], took.back(), took.size(), count);
}

void rate(int total) {
  constexpr int kThreads = 8;
  bip::Execution system(model::image(), {.seed = 1, .policy = bip::rt::Policy::First, .speed = 1});
  std::atomic<long> full{0};
  const Clock::time_point begin = Clock::now();
  std::vector<std::thread> posters;
  for (int t = 0; t < kThreads; ++t) {
    posters.emplace_back([&] {
      const std::uint32_t port = system.event_port("sink.take");
      for (int k = 0; k < total / kThreads; ++k) {
        while (system.post(port, {k}) == bip::Posted::Full) {
          ++full;
          std::this_thread::sleep_for(std::chrono::microseconds(200));
        }
      }
    });
  }
  std::thread last([&] {
    for (std::thread& poster : posters) poster.join();
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    system.stop();
  });
  Clock::time_point end = begin;
  long steps = 0;
  while (system.step() == bip::Outcome::Stepped) {
    ++steps;
    end = Clock::now();
  }
  last.join();
  std::int32_t taken = 0;
  (void)system.read("ROOT.sink.taken", taken);
  const double seconds = micros(end - begin) / 1e6;
  std::printf("8 threads: %.0f events/s, %d posted, %d taken, %d lost, told `full` %ld times\n", taken / seconds,
              total / kThreads * kThreads, taken, total / kThreads * kThreads - taken, full.load());
  if (steps != taken) std::printf("%ld steps\n", steps);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  latency(std::atoi(argv[1]));
  rate(std::atoi(argv[2]));
  return 0;
}
