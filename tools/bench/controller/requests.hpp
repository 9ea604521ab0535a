// A mission for a bench: requests one after the other, in the same process as the modules, with BIP or without.
//
// requests.txt, a line a step: `do SERVICE [INPUT]` asks and waits for the end, `start SERVICE [INPUT]` asks and waits
// for the acceptance, `await SERVICE` waits for an end, `sleep TICKS`. Anything but OK ends the program with 1; the
// last line ends it with 0 and tells how many ticks and how many seconds of the processor the mission took since the
// first tick. With $BENCH_REAL_TIME a tick begins every 10 ms.
#pragma once
#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

void request_input(const char* service, const char* input);
/// Called when the mission is over.
void at_end();

namespace bench {

class Requests {
 public:
  Requests() {
    std::ifstream in("requests.txt");
    for (std::string line; std::getline(in, line);) {
      Step s;
      std::istringstream words(line);
      words >> s.verb >> s.service >> std::ws;
      std::getline(words, s.input);
      if (!s.verb.empty()) steps_.push_back(std::move(s));
    }
  }

  // Once a tick: the next request, or nothing.
  std::string next() {
    if (ticks_++ == 0) begin_ = seconds();
    if (is_real_time_) std::this_thread::sleep_until(first_ + ticks_ * std::chrono::milliseconds(10));
    while (waits_ == Waits::Nothing || (waits_ == Waits::Time && ticks_ >= until_)) {
      if (at_ == steps_.size()) over();
      const Step& s = steps_[at_++];
      if (s.verb == "sleep") {
        until_ = ticks_ + std::atol(s.service.c_str());
        waits_ = Waits::Time;
      } else if (s.verb == "await") {
        waits_ = ended_.contains(s.service) ? Waits::Nothing : Waits::Reply;
      } else {
        ended_.erase(s.service);
        request_input(s.service.c_str(), s.input.c_str());
        waits_ = Waits::Answer;
        return s.service;
      }
    }
    return {};
  }
  void answer(const std::string& service, const std::string& report) {
    if (report != "OK") fail(service, report);
    if (waits_ == Waits::Answer) waits_ = steps_[at_ - 1].verb == "do" ? Waits::Reply : Waits::Nothing;
  }
  void reply(const std::string& service, const std::string& report) {
    if (report != "OK" && report != "ACTIVITY_INTERRUPTED") fail(service, report);
    ended_[service] = true;
    if (waits_ == Waits::Reply && steps_[at_ - 1].service == service) waits_ = Waits::Nothing;
  }

 private:
  enum class Waits { Nothing, Answer, Reply, Time };
  struct Step {
    std::string verb, service, input;
  };

  static double seconds() {
    rusage use{};
    getrusage(RUSAGE_SELF, &use);
    const auto of = [](const timeval& t) {
      return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6;
    };
    return of(use.ru_utime) + of(use.ru_stime);
  }
  [[noreturn]] static void leave(int code) {
    std::fflush(nullptr);
    std::_Exit(code);
  }
  [[noreturn]] void over() const {
    std::printf("over: %ld ticks, %.6f s\n", ticks_, seconds() - begin_);
    ::at_end();
    leave(0);
  }
  [[noreturn]] static void fail(const std::string& service, const std::string& report) {
    std::printf("%s: %s\n", service.c_str(), report.c_str());
    leave(1);
  }

  std::vector<Step> steps_;
  std::size_t at_ = 0;
  Waits waits_ = Waits::Nothing;
  std::map<std::string, bool> ended_;
  long ticks_ = 0, until_ = 0;
  double begin_ = 0;
  bool is_real_time_ = std::getenv("BENCH_REAL_TIME") != nullptr;
  std::chrono::steady_clock::time_point first_ = std::chrono::steady_clock::now();
};

inline Requests& requests() {
  static Requests r;
  return r;
}

}  // namespace bench
