// The decisional level: reads a file of procedures and asks for services, one at a time.
//
// A line a step; `#` begins a comment:
//   procedure NAME                        the steps up to the next one
//   do SERVICE [NUMBER …] [gets REPORT]     asks, and waits for the final reply: OK, or what is said
//   start SERVICE [NUMBER …]                asks, and waits until it is accepted
//   refused SERVICE [NUMBER …] gets REPORT  asks, and is refused so
//   await SERVICE [gets REPORT]             waits for the final reply of one that was started
//   call NAME | if rock NAME | sleep SECONDS | window | break ndd | say TEXT
// A service is MODULE.NAME, with the values of its parameters in parentheses if rules speak of them.
#pragma once
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "world.hpp"

namespace dala {

class Executive {
 public:
  explicit Executive(World& world) : world_(world) {
    std::ifstream in("mission.txt");
    if (!in) throw std::runtime_error("mission.txt is not here");
    std::string line, procedure;
    for (int number = 1; std::getline(in, line); ++number) read(line.substr(0, line.find('#')), number, procedure);
    stack_.push_back({"mission", 0});
  }

  // Once a tick.
  std::string next() {
    world_.now += kTick;
    if (ticks_++ % 25 == 0 && !stack_.empty()) path_ << world_.now << ' ' << world_.x << ' ' << world_.y << ' ' << world_.temperature << ' ' << world_.charge << '\n' << std::flush;
    if (waits_for_ == Waits::Time && world_.now >= until_) waits_for_ = Waits::Nothing;
    if (waits_for_ == Waits::Window && world_.orbiter_is_visible()) waits_for_ = Waits::Nothing;
    while (waits_for_ == Waits::Nothing && !stack_.empty()) {
      auto& [name, at] = stack_.back();
      const std::vector<Step>& steps = procedures_.at(name);
      if (at == steps.size()) {
        stack_.pop_back();
        if (stack_.empty() && world_.nearest < kRadius) ++surprises_;
        if (stack_.empty()) log("mission over: %.1f m driven, %d pictures, %d sent, nearest obstacle %.2f m, %d surprises", world_.driven, world_.pictures, world_.sent, world_.nearest, surprises_);
        continue;
      }
      step_ = steps[at++];
      const std::string request = begin();
      if (!request.empty()) return request;
    }
    return {};
  }

  void answer(const std::string& service, const std::string& report) {
    log("%s %s%s%s", report == "OK" ? "accepted" : "refused", service.c_str(), report == "OK" ? "" : ": ", report == "OK" ? "" : report.c_str());
    if (waits_for_ != Waits::Answer || bare(step_.service) != service) return;
    waits_for_ = Waits::Nothing;
    if (step_.verb == "refused") return expect(report);
    if (report != "OK") {
      // Nothing follows from it.
      if (step_.verb == "start" || step_.report == "OK") return expect(report);
      return expect(report);
    }
    if (step_.verb == "do" && !finished_.contains(service)) {
      if (is_control(service)) return expect(report);
      waits_for_ = Waits::Reply;
    }
  }

  void reply(const std::string& service, const std::string& report) {
    log("ended    %s: %s", service.c_str(), report.c_str());
    if (waits_for_ == Waits::Reply && bare(step_.service) == service) {
      waits_for_ = Waits::Nothing;
      return expect(report);
    }
    finished_[service] = report;
  }

  template <class... Args>
  void log(const char* format, Args... args) {
    std::printf("%8.2f  ", world_.now);
    std::printf(format, args...);
    std::printf("\n");
  }

  // Set by codels of control services, which have no final reply of their own.
  [[nodiscard]] static bool is_control(const std::string& service) {
    for (const char* name : {".Stop", ".TrackSpeedStop", ".StopAcquisition", ".StopMap", ".AddWindow", ".StopHeating", ".CreateBank"}) {
      if (service.ends_with(name)) return true;
    }
    return service.ends_with("EndUsingBattery");
  }

 private:
  enum class Waits { Nothing, Answer, Reply, Time, Window };
  struct Step {
    std::string verb, service, report = "OK", text;
    std::vector<double> numbers;
    int line = 0;
  };

  static std::string bare(const std::string& service) { return service.substr(0, service.find('(')); }

  void read(const std::string& line, int number, std::string& procedure) {
    std::istringstream words(line);
    Step s;
    s.line = number;
    if (!(words >> s.verb)) return;
    if (s.verb == "procedure") {
      words >> procedure;
      procedures_[procedure];
      return;
    }
    if (s.verb == "say") {
      std::getline(words >> std::ws, s.text);
    } else {
      std::string word;
      while (words >> word) {
        if (word == "gets") {
          words >> s.report;
        } else if (word.find_first_not_of("-.0123456789") == std::string::npos) {
          s.numbers.push_back(std::stod(word));
        } else {
          s.service = s.service.empty() ? word : s.service + " " + word;
        }
      }
    }
    procedures_[procedure].push_back(std::move(s));
  }

  // What is asked for, or nothing: then `waits_for_` says when it goes on.
  std::string begin() {
    if (step_.verb == "do" || step_.verb == "start" || step_.verb == "refused") {
      world_.arguments[bare(step_.service)] = step_.numbers;
      finished_.erase(bare(step_.service));
      waits_for_ = Waits::Answer;
      return step_.service;
    }
    if (step_.verb == "await") {
      if (const auto done = finished_.find(step_.service); done != finished_.end()) {
        const std::string report = done->second;
        expect(report);
      } else {
        waits_for_ = Waits::Reply;
      }
    } else if (step_.verb == "sleep") {
      until_ = world_.now + step_.numbers.at(0);
      waits_for_ = Waits::Time;
    } else if (step_.verb == "window") {
      waits_for_ = Waits::Window;
    } else if (step_.verb == "call") {
      stack_.push_back({step_.service, 0});
    } else if (step_.verb == "if") {
      if (world_.has_seen_rock) stack_.push_back({step_.service.substr(step_.service.find(' ') + 1), 0});
      world_.has_seen_rock = false;
    } else if (step_.verb == "break") {
      world_.ndd_is_stuck = true;
    } else if (step_.verb == "say") {
      log("%s", step_.text.c_str());
    } else {
      throw std::runtime_error("mission.txt:" + std::to_string(step_.line) + ": `" + step_.verb + "` is no step");
    }
    return {};
  }

  void expect(const std::string& report) {
    if (report == step_.report) return;
    ++surprises_;
    log("surprise in line %d: %s, not %s", step_.line, report.c_str(), step_.report.c_str());
  }

  World& world_;
  std::map<std::string, std::vector<Step>> procedures_;
  std::vector<std::pair<std::string, std::size_t>> stack_;
  std::map<std::string, std::string> finished_;
  Step step_;
  Waits waits_for_ = Waits::Nothing;
  std::ofstream path_{"mission.path"};
  long ticks_ = 0;
  double until_ = 0;
  int surprises_ = 0;
};

}  // namespace dala
