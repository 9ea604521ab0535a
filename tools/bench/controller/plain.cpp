// Modules without BIP: GenoM 2's run time as a plain program (tests/genom/reference.py in C++), over the same codels,
// to measure what a BIP controller costs beside it. modules.inc has the modules' tables (tools/bench/dala_cpu.py writes
// them); one thread, no sleeping.
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "dala_codels.hpp"
#include "requests.hpp"

namespace {

using Codel = int (*)(int&);
enum State { kEther, kStart, kExec, kEnd, kInter, kFail, kInit, kZombie = 201, kSleep = 202 };

struct Service {
  const char* name;
  char kind;  // e(xec), c(ontrol), i(nit)
  int task;
  int (*control)();
  Codel codels[5];  // start, main, end, inter, fail
  std::vector<const char*> reports;
  std::vector<int> interrupts;
  int instances;
};
struct Task {
  const char* name;
  int period;
  int (*permanent)();
};
struct Cell {
  int service = 0, state = kEther;
  bool ran = false;
  const char* report = nullptr;
};
struct Module {
  const char* name;
  std::vector<Task> tasks;
  std::vector<Service> services;
  std::vector<Cell> cells{};
  std::vector<bool> suspended{};
  bool is_suspended = false, is_initialised = true;
  std::string asked{};  // the mailbox
  double seconds = 0;   // codels included; only with `--split`, for looking at the clock costs more than some modules
};

std::vector<Module> modules{
#include "modules.inc"
};
constexpr int kControlPeriod = 2;
constexpr int kDefaults[] = {kExec, kEnd, kEther, kEther, kZombie};

// Which answers a state permits.
bool is_permitted(int state, int next) {
  if (next == kEther || next == kZombie) return state != kFail || next == kZombie;
  if (next == kFail) return state != kFail;
  if (next == kSleep || next == kExec) return state == kStart || state == kExec;
  if (next == kEnd) return state != kInter && state != kFail;
  return next == state && (state == kStart || state == kInter);
}

bool runs(const Cell& s) {
  return (s.state >= kStart && s.state <= kFail) || s.state == kSleep || (s.report != nullptr && s.ran);
}

void interrupt(Cell& s) {
  if (s.state == kInit) {
    s.state = kEther;
    s.report = "ACTIVITY_INTERRUPTED";
  } else if ((s.state >= kStart && s.state <= kFail) || s.state == kSleep) {
    s.state = kInter;
  }
}

template <class Work>
void each_interrupted(Module& m, int service, Work work) {
  for (Cell& s : m.cells) {
    for (const int other : m.services[static_cast<std::size_t>(service)].interrupts) {
      if (s.service == other) work(s);
    }
  }
}

void answer(const Module& m, const Service& s, const char* report) {
  bench::requests().answer(std::string(m.name) + "." + s.name, report);
}

void request(Module& m, int number) {
  const Service& s = m.services[static_cast<std::size_t>(number)];
  if (s.kind == 'e') {
    if (m.is_suspended) return answer(m, s, "SYSTEM_ERROR");
    if (!m.is_initialised) return answer(m, s, "WAIT_INIT_RQST");
    for (const Cell& cell : m.cells) {
      if (cell.state == kZombie) return answer(m, s, "WAIT_ABORT_ZOMBIE_ACTIVITY");
    }
  }
  Cell* free = nullptr;
  for (Cell& cell : m.cells) {
    if (free == nullptr && cell.service == number && cell.state == kEther && cell.report == nullptr) free = &cell;
  }
  if (s.kind != 'c' && free == nullptr) return answer(m, s, "TOO_MANY_ACTIVITIES");
  const int verdict = s.control != nullptr ? s.control() : 0;
  if (verdict != 0) return answer(m, s, s.reports.at(static_cast<std::size_t>(verdict - 1)));
  each_interrupted(m, number, [](Cell& cell) { interrupt(cell); });
  if (s.kind != 'c') *free = {number, kInit, false, nullptr};
  answer(m, s, "OK");
}

void control_cycle(Module& m) {
  for (Cell& s : m.cells) {
    if (s.report == nullptr) continue;
    bench::requests().reply(std::string(m.name) + "." + m.services[static_cast<std::size_t>(s.service)].name, s.report);
    s.report = nullptr;
  }
  if (!m.asked.empty()) {
    for (std::size_t k = 0; k < m.services.size(); ++k) {
      if (m.asked == m.services[k].name) request(m, static_cast<int>(k));
    }
    m.asked.clear();
  }
  for (Cell& s : m.cells) {
    if (s.state != kInit) continue;
    bool waits = false;
    each_interrupted(m, s.service, [&](Cell& other) { waits = waits || (&other != &s && runs(other)); });
    if (waits) continue;
    s.state = kStart;
    s.ran = true;
  }
}

void task_cycle(Module& m, std::size_t number) {
  if (m.suspended[number]) return;
  const Task& task = m.tasks[number];
  const auto suspend = [&] { m.suspended[number] = m.is_suspended = true; };
  if (task.permanent != nullptr && task.permanent() != 0) return suspend();
  for (Cell& s : m.cells) {
    const Service& service = m.services[static_cast<std::size_t>(s.service)];
    if (static_cast<std::size_t>(service.task) != number || s.state < kStart || s.state > kFail) continue;
    const int state = s.state;
    const Codel codel = service.codels[state - kStart];
    int report = 0;
    const int next = codel != nullptr ? codel(report) : kDefaults[state - kStart];
    if (!is_permitted(state, next)) return suspend();
    s.state = next;
    if (next == kEther)
      s.report = state == kInter ? "ACTIVITY_INTERRUPTED"
                 : report == 0   ? "OK"
                                 : service.reports.at(static_cast<std::size_t>(report - 1));
    if (next == kEther && service.kind == 'i' && report == 0) m.is_initialised = true;
    if (next == kZombie) s.report = "ACTIVITY_FAILED";
  }
}

}  // namespace

void at_end() {
  for (const Module& m : modules) std::printf("module %s %.6f\n", m.name, m.seconds);
}

int main(int count, char**) {
  const bool is_split = count > 1;
  for (Module& m : modules) {
    m.suspended.resize(m.tasks.size());
    for (std::size_t k = 0; k < m.services.size(); ++k) {
      m.is_initialised = m.is_initialised && m.services[k].kind != 'i';
      for (int n = 0; m.services[k].kind != 'c' && n < m.services[k].instances; ++n)
        m.cells.push_back({static_cast<int>(k)});
    }
  }
  for (long tick = 1;; ++tick) {
    const std::string wanted = bench::requests().next();
    for (Module& m : modules) {
      const std::string prefix = std::string(m.name) + ".";
      if (wanted.starts_with(prefix)) m.asked = wanted.substr(prefix.size());
    }
    for (Module& m : modules) {
      const auto begin = is_split ? std::chrono::steady_clock::now() : std::chrono::steady_clock::time_point{};
      if (tick % kControlPeriod == 0) control_cycle(m);
      for (std::size_t k = 0; k < m.tasks.size(); ++k) {
        if (tick % m.tasks[k].period == 0) task_cycle(m, k);
      }
      if (is_split) m.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    }
  }
}
