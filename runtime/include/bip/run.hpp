// Running an image: options and one call. The main() of emitted programs is in run_main.hpp.
#pragma once
#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>

#include "bip/image.hpp"
#include "bip/run_main.hpp"

namespace bip::rt {

class Profile;
struct NewCode;

enum class Policy : std::uint8_t { Uniform, First, Fair };
enum class TraceFormat : std::uint8_t { Steps, Json, Bip2, Binary, Mcap, Perfetto };
/// Sequential: one step after the other. Threads: atoms' transitions on several threads, steps that do not conflict
/// overlap. Batch: many steps between two meetings of the threads. Simulated: several nodes and the network between
/// them, by a seed, in one thread. Distributed: several nodes as processes. All make runs of the same semantics.
enum class Engine : std::uint8_t { Sequential, Threads, Batch, Simulated, Distributed };
[[nodiscard]] constexpr bool has_nodes(Engine engine) {
  return engine == Engine::Simulated || engine == Engine::Distributed;
}
/// What the others do when a node is lost: begin nothing more, or go on with what does not need it.
enum class OnLoss : std::uint8_t { Stop, GoOn };
struct Placement;
struct Deployment;
class FabricFactory;

struct RunOptions {
  std::uint64_t seed = 0;
  bool has_seed = false;        // false: one is drawn from the operating system; it is always printed
  std::uint64_t limit = ~0ull;  // steps
  Policy policy = Policy::Uniform;
  bool maximal_progress = true;
  Engine engine = Engine::Sequential;
  std::uint32_t threads = 0;  // of the engines that have several; 0: one a processor
  std::uint64_t perturb = 0;  // tests: threads wait at random places, by this seed; 0: they do not
  // Of engines with several nodes.
  std::uint32_t nodes = 4;  // unless there is a placement
  const Placement* placement =
      nullptr;                 // where atoms are at home (runtime/distributed/distribution.hpp); null: anywhere
  std::string network_faults;  // what goes wrong (runtime/distributed/faults.hpp)
  OnLoss on_loss = OnLoss::Stop;
  const FabricFactory* fabrics = nullptr;  // of processes (runtime/distributed/fabric.hpp); null: there is no network
  const Deployment* deployment = nullptr;  // on several hosts (runtime/distributed/deployment.hpp); null: on this one
  std::int64_t lost_after = 10000000000;   // ns of silence until a node on another host counts as lost
  std::int64_t checkpoint_every = 0;       // ns between checkpoints; 0: there are none
  std::string checkpoint_path;             // the last one, a file
  std::string resume_path;                 // the run goes on where this checkpoint was taken; empty: it begins
  // Models with time. Without `speed` time is logical: nothing sleeps.
  bool asap = false;          // each step at the first instant at which one is possible
  bool draws_resumes = true;  // of busy atoms, where instants are planned; false: the replay of a run that did not
  double speed = 0;           // model seconds a second of the wall clock
  bool relaxed = false;       // a step that starts too late is a warning
  int real_time_priority =
      0;  // in real time: SCHED_FIFO's, 1 to 99, and locked memory, if the system allows; 0: as usual
  // Events from outside, JSON lines. Without a file they come from the model's C++ classes.
  std::string events_path;
  std::string record_path;      // where they are written as they come; empty: nowhere
  std::string replay_path;      // such a record: repeats the run in logical time, its seed and policy too
  bool silent = false;          // no step lines; the seed and the end are still told
  bool show_state = false;      // where each atom is at the end, and its data
  bool stats = false;           // steps, seconds, ns/step, bytes at the end
  NewCode* new_code = nullptr;  // the image's code is replaced when it is ready (runtime/engine/code_replacement.hpp)
  Profile* profile = nullptr;   // measures the steps (runtime/core/profile.hpp)
  bool debug = false;           // every state's candidates
  // Lines that show a place of the source, with a newline at the end, below a run-time error. Empty, or what returns an
  // empty text: the place alone.
  std::function<std::string(SourceLine)> show_source;
  std::function<void(std::uint64_t steps)> on_progress;  // between many steps of a silent run
  std::function<void()> before_end;                      // before the end is reported
  bool interactive = false;                              // the candidates are listed and a number is read for each step
  std::FILE* input = nullptr;                            // interactive: where from; null: standard input
  bool explore = false;                                  // no run: all reachable states, at most `limit`
  TraceFormat format = TraceFormat::Steps;               // of standard output; Binary, Mcap, Perfetto: there as Steps
  std::string trace_path;  // JSON lines, or as `format` says if it is none of Steps and Json; empty: none
};

/// Final: no step is possible any more, and each atom is at a final place.
enum class End : std::uint8_t { Limit, Deadlock, Fault, Interrupted, Final };
struct RunResult {
  End end = End::Limit;
  std::uint64_t steps = 0;
  int exit_code = 0;  // 0 also for a deadlock (a normal end of a run); 1 for a run-time error
};

/// Runs from the initial state to the end that comes first. Writes steps to `out`, run-time errors to `err`.
RunResult run(const Image& image, const RunOptions& options, std::FILE* out, std::FILE* err);

/// One node of options.deployment, but the first: waits for the run that the first one begins, takes part in it, and
/// returns the exit code. The placement and the fabrics are needed, the other options are the first node's.
int run_node(const Image& image, const RunOptions& options);

/// How options.explore ends.
struct ExploreResult {
  std::uint64_t states = 0, deadlocks = 0, errors = 0;  // deadlocks: final states are none
  bool complete = true;                                 // false: the limit or Ctrl-C came first
  int exit_code = 0;                                    // 1 if a state has a run-time error
};
/// Fires every candidate of every reachable stable state, breadth first; with --silent only the last line is written.
ExploreResult explore(const Image& image, const RunOptions& options, std::FILE* out, std::FILE* err);

}  // namespace bip::rt
