// A program around a model: turnstile.bip runs in real time, 20 times as fast as the wall clock, and threads of
// visitors post events.
//
//   bipc emit --emit=cpp turnstile.bip > model.cpp
//   c++ -std=c++20 -DBIP_NO_MAIN -I RUNTIME/include -I RUNTIME/.. model.cpp turnstile.cpp libbip_runtime.a -pthread
//
// RUNTIME is the folder `runtime` of bipc (or of what `bipc emit -o DIR` writes). Ends with 0 if the model took every
// coin.
#include <atomic>
#include <chrono>
#include <cstdio>
#include <string>
#include <thread>
#include <vector>

#include "bip/bip.hpp"

namespace model {
const bip::rt::Image& image();
}

int main() {
  constexpr int kVisitors = 4, kCoins = 25;
  bip::Execution system(model::image(), {.seed = 1, .policy = bip::rt::Policy::First, .speed = 20});
  std::atomic<int> full{0};

  std::vector<std::thread> visitors;
  for (int v = 0; v < kVisitors; ++v) {
    visitors.emplace_back([&system, &full] {
      // A port is looked up once. The queue has a bound: who is told `Full` tries again.
      const std::uint32_t coin = system.event_port("arm.coin");
      for (int k = 0; k < kCoins; ++k) {
        while (system.post(coin, {1 + k % 2}) == bip::Posted::Full) ++full;
        (void)system.post("arm.push");
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    });
  }
  // When all have gone the arm locks itself, and nothing happens any more.
  std::thread last([&] {
    for (std::thread& visitor : visitors) visitor.join();
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    system.stop();
  });

  int coins = 0;
  system.on_step([&coins](const bip::Step& step) { coins += step.interaction == "ROOT.arm.coin" ? 1 : 0; });
  while (system.step() == bip::Outcome::Stepped) {
  }
  last.join();

  std::int32_t total = 0, passed = 0;
  const bool sound = system.outcome() == bip::Outcome::Stopped && system.read("ROOT.arm.total", total) &&
                     system.read("ROOT.arm.passed", passed);
  if (!sound) {
    std::fputs(system.fault().c_str(), stderr);
    return 1;
  }
  std::printf("%d coins worth %d, %s passed, the arm is %s\n", coins, total, passed > 0 ? "some" : "none",
              system.place("ROOT.arm").c_str());
  return coins == kVisitors * kCoins && total == kVisitors * (kCoins + kCoins / 2) && passed > 0 ? 0 : 1;
}
