// A model that runs on its own thread while other threads post events, observe it, pause it and restore it.
//
// Access to more than events is a function, which the engine's thread executes between two steps, so no observer sees a
// state half-way through a step. A sleeping engine is woken for it. No cost while there are no requests.
#pragma once
#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "bip/bip.hpp"
#include "compiler/serve/requests.hpp"
#include "compiler/serve/watchdog.hpp"

namespace bip::serve {

class Controller {
 public:
  /// Runs on the engine's thread.
  using Command = std::function<void(Controller&)>;
  static constexpr std::size_t kMaxSnapshots = 16;

  enum class Begin : std::uint8_t { Running, Paused };
  Controller(const rt::Image& image, const ExecutionOptions& options, Begin begin, const WatchOptions& watch = {});
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;
  ~Controller();
  /// Both are called on the engine's thread; set before start().
  std::function<void(const Step&, std::int64_t now)> on_step;
  std::function<void(Outcome outcome, const std::string& text)> on_end;
  /// The watchdog's; set before start().
  std::function<void(const Alarm&)>& on_alarm() { return watchdog_.on_alarm; }
  /// Of that thread (bip/real_time_thread.hpp); on_problem hears what is refused. Set before start().
  int real_time_priority = 0;
  std::function<void(const std::string&)> on_problem;
  /// Before start(): the steps go to a file; end_trace() after halt(). False: it cannot be written.
  [[nodiscard]] bool trace(const std::string& path, rt::TraceFormat format) { return system_.trace(path, format); }
  [[nodiscard]] bool end_trace() { return system_.end_trace(); }
  void start();
  /// Ends the thread; nothing is called afterwards.
  void halt();

  // ---- any thread
  [[nodiscard]] const rt::Image& image() const { return image_; }
  [[nodiscard]] Execution& events() { return system_; }  // post() and event_port() only
  /// For services of robot modules; its own functions say from which thread.
  [[nodiscard]] Requests& requests() { return requests_; }
  void ask(Command command);
  /// A client follows the steps: on_step gets the names of all steps. Else it gets those of steps with requests or
  /// replies only.
  void name_all_steps(bool on) { system_.name_all_steps(on || watchdog_.names_steps()); }
  /// Calls the safe-stop function, if there is one.
  void stop_robot(std::string why) { watchdog_.stop_robot(std::move(why)); }

  // ---- in a command
  [[nodiscard]] const Execution& system() const { return system_; }
  [[nodiscard]] bool is_paused() const { return is_paused_; }
  [[nodiscard]] bool has_ended() const { return has_ended_; }
  /// The model's time stands still, so the robot is stopped, if there is a safe-stop function.
  void pause();
  /// Runs on; steps > 0: only so many. The wall clock goes on from the model's instant.
  void resume(std::uint64_t steps);
  /// The number to restore it by; false if there are too many.
  [[nodiscard]] bool save(std::size_t& number);
  [[nodiscard]] bool restore(std::size_t number);
  /// Takes candidate k of this instant; while paused only. Returns an empty text, or why not.
  [[nodiscard]] std::string fire(std::uint64_t k);
  /// Undoes steps that fire() took, or resume() with a number of steps, since the model last ran freely: at most 1,000,
  /// and as many as fit in 64 MiB. Returns an empty text, or why not.
  [[nodiscard]] std::string back(std::uint64_t count);

 private:
  void run();
  void note_outcome(Outcome outcome);
  void end(Outcome outcome);
  void note_state();
  void drop_state();
  void forget_states();

  static constexpr std::size_t kMostUndone = 1000, kMostUndoneBytes = std::size_t{64} << 20;
  const rt::Image& image_;
  Execution system_;
  Requests requests_;
  Watchdog watchdog_;
  std::vector<Execution::Snapshot> snapshots_;
  std::deque<Execution::Snapshot> undo_;  // before each of the last steps that a client asked for
  std::size_t undo_bytes_ = 0;
  std::function<bool(const Step&)> breaks_;
  bool is_paused_;
  bool has_ended_ = false;
  std::uint64_t steps_left_ = 0;  // 0: no end

  std::mutex lock_;
  std::condition_variable changed_;
  std::deque<Command> commands_;
  bool quits_ = false;
  std::atomic<bool> is_asked_{false};  // written under the lock: there are commands, or it quits
  std::thread thread_;
};

}  // namespace bip::serve
