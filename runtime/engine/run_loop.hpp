// The loop of a run: initialize, then wait, choose and fire until the limit, a deadlock, a fault or Ctrl-C, then
// report.
//
// Needs an image and options that `run` accepted. Each phase is a function; their order is asserted. A run that writes
// no steps and chooses uniformly takes compiled steps in bulk: then a turn of the loop is millions of steps. Otherwise
// a turn is one step, and the loop adds to it some comparisons of flags and no allocation.
#pragma once
#include <chrono>
#include <cstdio>
#include <ctime>
#include <memory>
#include <optional>
#include <string>

#include "bip/real_time_thread.hpp"
#include "bip/run.hpp"
#include "runtime/engine/batch_engine.hpp"
#include "runtime/engine/checkpoints.hpp"
#include "runtime/engine/event_feed.hpp"
#include "runtime/engine/interrupt.hpp"
#include "runtime/engine/launcher.hpp"
#include "runtime/engine/output.hpp"
#include "runtime/engine/real_time.hpp"
#include "runtime/engine/run_file.hpp"
#include "runtime/engine/run_statistics.hpp"
#include "runtime/engine/scheduler.hpp"
#include "runtime/engine/simulated.hpp"
#include "runtime/engine/threads.hpp"
#include "runtime/engine/limiting_ports.hpp"
#include "runtime/engine/timed_scheduler.hpp"

namespace bip::rt {

struct RunFiles {
  std::FILE* out;
  std::FILE* err;
  RunFile& trace;
  RunFile& record;
};

class RunLoop {
 public:
  /// Links the image. All arguments must outlive the loop. `recorded` is the record that the run repeats, or an empty
  /// one; the head of `output` was written.
  RunLoop(const Image& image, const RunOptions& options, const Record& recorded, std::uint64_t seed, Output& output,
          const RunFiles& files);
  RunLoop(const RunLoop&) = delete;
  RunLoop& operator=(const RunLoop&) = delete;

  /// Runs from the initial state to the end that comes first, and reports it. Once. Errors of the files of events and
  /// records give exit code 2.
  RunResult run();

 private:
  enum class Phase : std::uint8_t { Created, EventsOpened, Initialized, Ended };
  enum class Choice : std::uint8_t { Made, InputEnded };

  // The phases, in their order.
  [[nodiscard]] bool open_events();
  void begin_record();
  void initialize();
  [[nodiscard]] bool resume_run();
  void start_real_time();
  void start_measuring();
  void run_on_threads();
  void run_on_nodes();
  void advance();
  void finish();

  // One turn of the loop.
  [[nodiscard]] std::optional<End> find_end() const;
  [[nodiscard]] bool take_new_code();
  [[nodiscard]] Due wait();
  void take_steps();
  void take_batch();
  void take_compiled_steps();
  void take_quiet_steps();
  void take_one_step();
  [[nodiscard]] Choice choose(EnabledSet::Position& at);
  [[nodiscard]] bool is_in_time(EnabledSet::Position at);
  void fire(EnabledSet::Position at);
  void end_with(End end);

  // Parts of finish().
  void report_end();
  [[nodiscard]] std::string last_steps() const;
  void end_record();
  void close_files();
  void compare_with_recorded_end();
  void print_statistics();
  void print_node_statistics();
  void print_processor_use();

  [[nodiscard]] bool can_be_compiled() const;
  [[nodiscard]] bool can_be_quiet() const;
  [[nodiscard]] bool is_new_code_ready() const;
  [[nodiscard]] bool is_replay() const { return !options_.replay_path.empty(); }

  const Image& image_;
  const RunOptions& options_;
  const Record& recorded_;
  std::uint64_t seed_;
  Output& output_;
  RunFiles files_;
  NewCode* new_code_;  // null: none will come
  Core core_;
  Scheduler scheduler_;   // of models without time
  TimedScheduler timed_;  // of models with time
  LimitingPorts limiting_{core_};
  EventFeed feed_;
  InterruptGuard interrupt_guard_;
  RealTime wall_;
  std::unique_ptr<RealTimeThread> real_time_thread_;
  std::unique_ptr<BatchEngine> batch_;
  ThreadedResult threaded_;
  DistributedResult distributed_;  // of engines with several nodes
  Checkpoint resumed_;             // where the run goes on, if it does
  std::unique_ptr<CheckpointSignal> checkpoint_signal_;

  Phase phase_ = Phase::Created;
  bool writes_;                  // the steps, somewhere
  bool sleeps_ = false;          // until the instants of steps come on the wall clock
  bool is_sound_ = false;        // false: the core has a fault
  bool is_step_faulty_ = false;  // the fault is of a step that was begun: the last one of the history
  bool is_compiled_ = false;     // steps are taken in bulk
  bool is_quiet_ = false;        // steps are taken without a look at anything but the core and the limit
  RunResult result_;
  EnabledSizes enabled_sizes_;
  std::chrono::steady_clock::time_point started_;
  std::clock_t cpu_started_ = 0;
  double seconds_ = 0, own_cpu_seconds_ = 0;  // of this process
};

}  // namespace bip::rt
