// Many runs of one model in one process, each with a seed of its own, and what was observed in each.
//
// Run k is what `bipc run --seed SEED+k` is, so that any of them can be looked at. Runs are independent of each other
// and results are kept by run, so they are the same whatever the number of threads.
//
// Cost: the steps of all runs, and what the observers read after each; without observers of single steps compiled steps
// are taken. Memory: a number an observer and a run.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "bip/run.hpp"
#include "runtime/core/core.hpp"
#include "runtime/engine/path_query.hpp"

namespace bip::rt {

/// What an observer makes of a run. Durations are of model time, in seconds; without time in steps.
enum class ObserverKind : std::uint8_t {
  Count,     // steps of a connector, or of a port
  Reaches,   // 1 if the expression holds in some state, else 0
  Time,      // when it holds first; undefined if it never does
  Duration,  // how long it holds
  Max,       // the largest value
  Min,
  Mean,  // weighted by duration; in a run without duration the first value
  Last   // the value at the end
};
struct Observer {
  std::string text;  // as it was asked for
  ObserverKind kind = ObserverKind::Count;
  u32 connector = kNone;                     // Count: its steps
  u32 atom = kNone, port = kNone;            // Count: steps in which the port takes part
  std::function<double(const Core&)> value;  // the others; called by any thread
};
struct SimulateOptions {
  std::uint64_t runs = 1000;
  std::uint64_t seed = 0;      // of the first run; the next one has the next
  std::uint64_t limit = 1000;  // steps of a run
  i64 until = kForever;        // instant of the model at which a run ends
  u32 threads = 1;
  Policy policy = Policy::Uniform;
  bool asap = false;
  MaximalProgress progress = MaximalProgress::On;
  std::vector<Observer> observers;
  std::vector<PathQuery> queries;                       // without observers a run ends when all are answered
  std::function<bool(const Core&)> stop;                // a run ends at the first state in which it holds
  std::function<void(std::uint64_t runs)> on_progress;  // runs that are done; called by one thread
  std::function<bool()> is_stopped;                     // ends all runs early; called by any thread
};
/// How a run ended. Time: at `until`. Stop: in a state in which `stop` holds. Answered: all queries were.
enum class SimulatedEnd : std::uint8_t { Limit, Deadlock, Fault, Final, Time, Stop, Answered, NotRun };
inline constexpr std::size_t kSimulatedEnds = 7;
[[nodiscard]] const char* name_of(SimulatedEnd end);

struct SimulateReport {
  bool is_complete = true;                   // false: interrupted, and what is NotRun has no values
  std::vector<SimulatedEnd> ends;            // by run
  std::vector<std::uint64_t> steps;          // by run
  std::vector<double> times;                 // by run: the instant of its end in seconds; empty without time
  std::vector<std::vector<double>> values;   // by observer, by run; NaN: undefined
  std::vector<std::vector<Answer>> answers;  // by query, by run; Open: the run ended before
  std::string first_fault;                   // of the first run that ended so
};
/// Makes the runs. The image must have its code. Reports errors of runs as ends, not by throwing.
[[nodiscard]] SimulateReport simulate(const Image& image, const SimulateOptions& options);

}  // namespace bip::rt
