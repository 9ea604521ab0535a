// Embedding: runs the image of a model step by step inside another program.
//
// The image must outlive the Execution, which owns everything else. No function throws. A run-time error of the model
// stops the execution: every further step returns Outcome::Fault, and fault() has the text. One Execution is used by
// one thread at a time, except for post() and stop(); different Executions are independent.
//
//   bip::Execution system(model::image(), {.seed = 42});
//   system.on_step([](const bip::Step& step) { std::puts(step.interaction.c_str()); });
//   while (system.step() == bip::Outcome::Stepped) {}
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bip/events.hpp"
#include "bip/image.hpp"
#include "bip/run.hpp"

namespace bip {

struct ExecutionOptions {
  std::uint64_t seed = 0;
  rt::Policy policy = rt::Policy::Uniform;
  bool maximal_progress = true;
  bool asap = false;  // models with clocks: take each step at the earliest instant at which it is possible
  // Seconds of model time per second of the wall clock: step() sleeps until its step is due, and waits for events if no
  // step is. 0: logical time, which passes without waiting.
  double speed = 0;
  // With `speed`: a step that starts later than its guard allows is a fault, R0022. If false, such steps are only
  // counted, because a model that receives more events than it can take is always late.
  bool strict = false;
  std::uint32_t event_capacity = 65536;  // greatest number of events that wait for one port
};
/// How a call ended: a step was taken, there is no candidate, a run-time error (see fault()), or stop() was called.
enum class Outcome : std::uint8_t { Stepped, Deadlock, Fault, Stopped, Final };
/// The result of post(). Full: event_capacity events wait for this port already. BadValues: number or types of the
/// values are not those of the port's type.
enum class Posted : std::uint8_t { Taken, Full, NoSuchPort, BadValues };

/// The value of a port's variable when the interaction was chosen, before `down`. For a C++ type: its text.
struct StepValue {
  std::uint32_t port = 0;  // row of Step::ports
  const char* name = "";   // of the variable in the port's type; valid as long as the image
  EventValue value;
};
/// A step: the interaction that was fired.
struct Step {
  std::uint64_t number = 0;        // counted from 0
  std::string interaction;         // "ROOT.take0", or "ROOT.a.think" for an internal port
  std::vector<std::string> ports;  // "ROOT.p0.take", in the order of firing
  std::vector<StepValue> values;   // by port
};

class Execution {
 public:
  /// Initializes the model: initial actions, then internal transitions. If that ends with a run-time error, outcome()
  /// is Fault. Linear in the system.
  explicit Execution(const rt::Image& image, ExecutionOptions options = {});
  ~Execution();
  Execution(Execution&&) noexcept;
  Execution& operator=(Execution&&) noexcept;

  /// Returns how the last call that changed the execution ended; Stepped after a successful initialization.
  [[nodiscard]] Outcome outcome() const;
  /// Takes one step that the policy chooses. In a model with clocks, time first passes to the instant of the step:
  /// without waiting in logical time, sleeping with `speed`.
  Outcome step();
  /// Takes up to n steps and returns how many were taken; if fewer, outcome() says why. Uses compiled steps if n is
  /// large and neither a callback nor a trace is set.
  std::uint64_t run(std::uint64_t n);
  /// Returns the number of steps since the start; restore() sets it to that of the snapshot.
  [[nodiscard]] std::uint64_t steps() const;

  /// Posts an external event to an `extern port`, "ROOT.panel.turn" with or without "ROOT.", with one value for each
  /// variable of the port's type, in their order. May be called by any thread, also while another one is in step(). The
  /// event arrives at the instant of the wall clock; in logical time, at that of the next step(). After Deadlock the
  /// execution continues if an event enables a step.
  Posted post(const std::string& port, std::vector<EventValue> values = {});
  /// Returns a number for post() that saves the look-up of the name; rt::kNone if there is no such port.
  [[nodiscard]] std::uint32_t event_port(const std::string& port) const;
  /// Posts an event to the port of that number, as event_port() returned it, with one value for each variable of the
  /// port's type. NoSuchPort: the number is rt::kNone or no port's. May be called by any thread. Linear in the values.
  Posted post(std::uint32_t event_port, std::vector<EventValue> values);
  /// Ends a waiting step(), and each one that would wait, with Stopped, until go_on(). May be called by any thread.
  void stop();
  /// Ends the effect of stop(): further calls of step() wait again. Changes nothing without a stop() before it. May be
  /// called by any thread.
  void go_on();
  /// With `speed`: aligns the wall clock with the model's instant, as after a pause. Waiting events arrive now.
  void restart_clock();

  /// Returns the number of steps that started later than their guards allow (with `speed`).
  [[nodiscard]] std::uint64_t late_steps() const;
  /// With `speed`: how much later than it was due the last step began, in ns of the wall clock.
  [[nodiscard]] std::int64_t lateness() const;
  /// When a waiting step() woke up last, in ns of the monotonic clock; 0 while it sleeps. May be called by any thread:
  /// what is awake for long in one step() has stalled.
  [[nodiscard]] std::int64_t awake_since() const;
  /// Returns the number of `@async` actions that exceeded their budgets (with `speed`).
  [[nodiscard]] std::uint64_t overruns() const;

  /// Returns the model's instant in ns since the start; 0 in a model without clocks.
  [[nodiscard]] std::int64_t now() const;

  /// Returns the number of candidates at this instant; 0 after a fault. In a model with clocks, 0 does not mean
  /// deadlock: candidates may appear when time passes.
  [[nodiscard]] std::uint64_t candidate_count() const;
  /// Returns the name of candidate k, as in Step::interaction. Requires k < candidate_count().
  [[nodiscard]] std::string candidate(std::uint64_t k) const;
  /// Returns the ports that take part in candidate k, as in Step::ports. Requires k < candidate_count().
  [[nodiscard]] std::vector<std::string> candidate_ports(std::uint64_t k) const;
  /// Takes candidate k instead of asking the policy. Deadlock if there is no candidate k.
  Outcome fire(std::uint64_t k);

  /// Sets a function that is called after each step, on the thread that steps. An empty function removes it.
  void on_step(std::function<void(const Step&)> callback);
  /// The same for who needs few steps: `needs` is asked once for each port of the model, by its path. Of a step in
  /// which none of the ports takes part for which it returned true the Step has its number only, which saves making
  /// names.
  void on_step(std::function<void(const Step&)> callback, const std::function<bool(const std::string& port)>& needs);
  /// Gives all further steps their names, whatever `needs` said. May be called from any thread.
  void name_all_steps(bool on);

  /// Writes a trace of all further steps to a file, as --trace does: Json, Mcap or Perfetto. Returns false if the file
  /// cannot be opened.
  bool trace(const std::string& path, rt::TraceFormat format);
  /// Completes the trace's file. Returns false if not all of it could be written.
  bool end_trace();

  /// Returns the place of an atom, or the marked places of a Petri net ("A, B"), by its path "ROOT.a"; empty if there
  /// is no such atom.
  [[nodiscard]] std::string place(const std::string& atom_path) const;
  /// Reads a variable of type int by its path, "ROOT.a.x". Returns false, and leaves `value` unchanged, if there is no
  /// such variable of this type. Logarithmic in the number of atoms, linear in the variables of the atom.
  bool read(const std::string& path, std::int32_t& value) const;
  /// Reads a variable of type bool; result, errors and cost as for int.
  bool read(const std::string& path, bool& value) const;
  /// Reads a variable of type float; result, errors and cost as for int.
  bool read(const std::string& path, double& value) const;
  /// Reads a variable of type string into `value`, which then owns a copy; result and errors as for int.
  bool read(const std::string& path, std::string& value) const;
  /// A clock of an atom: it was `value` at the instant `since` and has run with `speed`; both in ns.
  struct ClockReading {
    std::string name;
    std::int64_t value = 0, since = 0;
    double speed = 1;
    std::int64_t unit = 1;  // in which the model compares and sets it, in ns
  };
  /// Returns the clocks of an atom by its path, in the order of their declarations; none if there is no such atom.
  [[nodiscard]] std::vector<ClockReading> clocks(const std::string& atom_path) const;

  /// State, number of steps and the policy's memory: a run continued from a snapshot repeats the run that followed it.
  class Snapshot {
   public:
    ~Snapshot();
    Snapshot(Snapshot&&) noexcept;
    Snapshot& operator=(Snapshot&&) noexcept;
    /// Returns about how much memory it takes; objects of C++ types count as pointers.
    [[nodiscard]] std::size_t bytes() const;

   private:
    friend class Execution;
    Snapshot();
    struct Impl;
    std::unique_ptr<Impl> impl_;
  };
  /// Returns a copy of the state, which the caller owns; restore() can take it any number of times. Callbacks and the
  /// trace are not in it. Objects of C++ types are copied; strings that the state has are never freed from then on.
  /// Linear in the state.
  [[nodiscard]] Snapshot snapshot() const;
  /// Restores a snapshot of an execution of the same image. With `speed`, the wall clock is aligned with its instant.
  void restore(const Snapshot& snapshot);

  /// Returns the text of the run-time error; empty if there is none.
  [[nodiscard]] std::string fault() const;
  /// Returns the explanation of a deadlock (which component waits for which); empty if the state is not a deadlock.
  [[nodiscard]] std::string story() const;
  /// Returns why an interaction or a port, "ROOT.k" or "ROOT.a.p" with or without "ROOT.", is not possible now: lines,
  /// of which the first says whether it is. Empty if there is none of this name, and after a fault.
  [[nodiscard]] std::string why(const std::string& path) const;

 private:
  struct Impl;
  struct TraceFile;
  std::unique_ptr<Impl> impl_;
};

}  // namespace bip
