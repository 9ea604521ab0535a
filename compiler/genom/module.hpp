// The description of one robot module, for both generations of GenoM: the input of the generator, without the rest of a
// .gen file.
//
// The two front ends fill it with names; `resolve` (resolve_module.hpp) checks the names and fills the indices. Rows
// keep the order of the file, which is the order of request numbers and of activities.
#pragma once
#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/genom/idl.hpp"
#include "compiler/source/source.hpp"

namespace bip::genom {

struct Name {
  std::string text;
  SourceRange range;
  [[nodiscard]] bool is_set() const { return !text.empty(); }
};

/// What codels answer: anything that their state permits, or what C++ functions of their names return.
enum class Flavour : std::uint8_t { Verification, Execution };

/// What a codel may answer. `Other` is anything that its state does not permit: it suspends the task.
enum class Next : std::uint8_t { State, Pause, Ether, Zombie, Sleep, Other };
struct Yield {
  Next next = Next::State;
  Name name;
  std::size_t state = 0;  // of Next::State and Next::Pause, after `resolve`
};

/// Shared data that a codel touches: an ids member or a port.
struct DataUse {
  std::string data;
  bool writes = false;
};

/// A function that the user writes in C or C++.
struct Codel {
  Name name;
  std::vector<DataUse> uses;
  bool is_async = false;       // runs beside its task, which goes on meanwhile
  std::int64_t budget_us = 0;  // its longest time, after which an async one is given up; 0: none is known
};

/// States of an activity whose codels C++ runs: a codel answers 1 + k for the k-th state, 101 + k for it after a pause.
inline constexpr std::size_t kMaxCalledStates = 100;

/// One state of an activity. Without a codel it passes on as its default says; that costs its turn all the same.
struct State {
  Name name;
  Codel codel;
  std::vector<Yield> yields;
};

/// The automaton of an activity (Bensalem, de Silva, Ingrand, Yan 2011, Figure 3). `stop` is where an interrupted one
/// goes.
struct Activity {
  std::vector<State> states;
  std::size_t start = 0;
  std::size_t stop = 0;
};

enum class ServiceKind : std::uint8_t { Execution, Control };
struct Service {
  Name name;
  ServiceKind kind = ServiceKind::Control;
  bool is_init = false;
  bool waits = false;      // its trigger may have to wait for a constraint: the lock is given back meanwhile
  bool overtakes = false;  // the side file says so: its requests wait for no others of the module
  std::string doc;
  Name task;  // of an execution service
  std::size_t task_index = 0;
  Codel validate;              // looks at the parameters before anything is interrupted
  bool validate_fails = true;  // the side file may say that it never refuses
  std::vector<Codel> body;     // of a control service
  bool body_fails = true;
  Activity activity;                // of an execution service
  std::vector<Name> reports;        // the service's own
  std::vector<std::string> inputs;  // GenoM 3: names of the parameters that a request brings
  bool interrupts_all = false;
  std::vector<Name> interrupts;
  std::vector<std::size_t> interrupted;  // indices, execution services only
  std::vector<Name> before, after;
  std::vector<std::size_t> before_index, after_index;  // others
  bool is_before_itself = false, is_after_itself = false;
  std::size_t instances = 1;
};

struct Task {
  Name name;
  std::int64_t period_us = 0;  // 0: aperiodic, woken by the control task
  std::int64_t delay_us = 0;
  Codel permanent;  // GenoM 2: run in each cycle
  bool permanent_fails = true;
  Activity activity;                    // GenoM 3: the task's own codels; no states if it has none
  std::vector<Name> reads;              // posters of other modules, "Module.Poster", read when a cycle begins
  std::vector<std::int64_t> freshness;  // by `reads`: a cycle begins only if it is younger; 0: however old it is
  [[nodiscard]] bool has_permanent() const { return permanent.name.is_set() || !activity.states.empty(); }
};

/// GenoM 2: a member NAME of a poster, with what stands at PATH in the module's data.
struct DataRef {
  std::string name;
  std::vector<std::string> path;  // empty: all of it
};
/// A C struct of a GenoM 2 description. Types are words with a blank between them; -1: a length that is no number.
struct CMember {
  std::string type, name;
  std::vector<std::int64_t> dimensions;
};
struct CStruct {
  std::string name, tag;
  std::vector<CMember> members;
};

struct Poster {
  Name name;
  Name task;  // the writer (GenoM 2)
  std::size_t task_index = 0;
  bool is_auto = false;  // written at the end of each cycle of its task; else by codels, when they like
  std::vector<DataRef> data{};
};

/// GenoM 3. `type` is its name in C; empty: a header that may declare it was missing.
struct Port {
  std::string name, type;
  bool is_out = false, is_multiple = false;
};
/// Does the in port read the out port of another component until `connect_port` names another one? Types that are not
/// known are taken to be equal.
[[nodiscard]] inline bool reads_by_itself(const Port& in, const Port& out) {
  const bool has_same_type = in.type == out.type || in.type.empty() || out.type.empty();
  return !in.is_out && out.is_out && in.name == out.name && in.is_multiple == out.is_multiple && has_same_type;
}

struct Module {
  Name name;
  int generation = 2;
  std::int64_t tick_us = 10000;  // unit in which the description counts time
  std::vector<Service> services;
  std::vector<Task> tasks;
  std::vector<Poster> posters;              // GenoM 3: ports out
  std::vector<Port> ports;                  // GenoM 3, by name; nothing of the translation depends on them
  std::string data_type;                    // GenoM 2: its internal data, one of `structs` if it is described
  std::vector<CStruct> structs;             // GenoM 2; nothing of the translation depends on them
  std::optional<idl::Component> component;  // GenoM 3, if its codels are called in C
  bool is_killed = false;                   // it has genom3's service `kill`, which also stops its tasks
  bool is_open = false;                     // a header was missing: names that are not known may be declared there
  [[nodiscard]] bool has_init() const {
    for (const Service& s : services) {
      if (s.is_init) return true;
    }
    return false;
  }
  [[nodiscard]] bool has_async() const {
    const auto runs_beside = [](const auto& owner) {
      for (const State& state : owner.activity.states) {
        if (state.codel.is_async) return true;
      }
      return false;
    };
    return std::any_of(services.begin(), services.end(), runs_beside) ||
           std::any_of(tasks.begin(), tasks.end(), runs_beside);
  }
};

}  // namespace bip::genom
