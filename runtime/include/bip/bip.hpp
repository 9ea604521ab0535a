// Embedding: run a linked image step by step in another program. The image must outlive the Execution; everything else
// the Execution owns. Nothing is thrown; a fault stops it, and fault() has the text.
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
  bool asap = false;  // models with time: each step as soon as it is possible
  // Model seconds a second: step() sleeps until its step is due, and waits for events if there is none. 0: logical
  // time.
  double speed = 0;
  // With `speed`: a step that starts later than its guard allows is a fault, R0022. Without it is only counted: under a
  // flood of events the model is always behind.
  bool strict = false;
  std::uint32_t event_capacity = 65536;  // events that may wait for a port
};
enum class Outcome : std::uint8_t { Stepped, Deadlock, Fault, Stopped };
/// What became of an event. Full: as many as may wait do; the model takes them slower than they come.
enum class Posted : std::uint8_t { Taken, Full, NoSuchPort, BadValues };

/// A variable of a port, as it was when the interaction was chosen. Of a C++ type: its text.
struct StepValue {
  std::uint32_t port = 0;  // row of Step::ports
  const char* name = "";   // in the port's type; lives as long as the image
  EventValue value;
};
/// An interaction that was taken.
struct Step {
  std::uint64_t number = 0;
  std::string interaction;         // "ROOT.take0", or "ROOT.a.think" for an internal port
  std::vector<std::string> ports;  // "ROOT.p0.take", in the order of firing
  std::vector<StepValue> values;   // by port
};

class Execution {
 public:
  /// Initializes; if that faults, outcome() says so.
  explicit Execution(const rt::Image& image, ExecutionOptions options = {});
  ~Execution();
  Execution(Execution&&) noexcept;
  Execution& operator=(Execution&&) noexcept;

  /// How the last call ended; Stepped after a good start.
  [[nodiscard]] Outcome outcome() const;
  /// One step, chosen by the policy. In a model with time the time until then passes first, without sleeping.
  Outcome step();
  /// Up to n steps; how many were taken.
  std::uint64_t run(std::uint64_t n);
  /// Steps taken since the start, or as the restored snapshot has it.
  [[nodiscard]] std::uint64_t steps() const;

  /// An event from outside for `extern port`s, "ROOT.panel.turn" with or without "ROOT.", with a value for each
  /// variable of the port's type. From any thread, also while another one is in step(); it comes at the instant of the
  /// wall clock, in logical time at that of the next step(). After Deadlock the model goes on if an event helps.
  Posted post(const std::string& port, std::vector<EventValue> values = {});
  /// The same without looking for the name each time. kNone: there is no such port.
  [[nodiscard]] std::uint32_t event_port(const std::string& port) const;
  Posted post(std::uint32_t event_port, std::vector<EventValue> values);
  /// From any thread: step() that waits, or the next that would, ends with Stopped. Until go_on().
  void stop();
  void go_on();
  /// With `speed`: now is the model's instant, as after a pause. Events that wait come now.
  void restart_clock();

  /// With `speed`: steps that started later than their guards allow.
  [[nodiscard]] std::uint64_t late_steps() const;
  /// With `speed`: actions that run beside the others (`@async`) and used up their budgets.
  [[nodiscard]] std::uint64_t overruns() const;

  /// The instant, in ns since the start; 0 in a model without time.
  [[nodiscard]] std::int64_t now() const;

  /// Of this instant: in a model with time there may be none although time brings some.
  [[nodiscard]] std::uint64_t candidate_count() const;
  /// The interaction's name, as in Step. k < candidate_count().
  [[nodiscard]] std::string candidate(std::uint64_t k) const;
  /// Takes the k-th candidate instead of asking the policy.
  Outcome fire(std::uint64_t k);

  /// Called after each step.
  void on_step(std::function<void(const Step&)> callback);

  /// Writes the steps from now on to a file, as --trace does: Json, Mcap or Perfetto. False: it cannot be opened.
  bool trace(const std::string& path, rt::TraceFormat format);
  /// Ends the file, which is not complete before. False: not all of it could be written.
  bool end_trace();

  /// The place(s) of an atom, "A" or "A, B"; empty if there is no such atom. "ROOT.a".
  [[nodiscard]] std::string place(const std::string& atom_path) const;
  /// A variable by path, "ROOT.a.x". False: no such variable, or of another type.
  bool read(const std::string& path, std::int32_t& value) const;
  bool read(const std::string& path, bool& value) const;
  bool read(const std::string& path, double& value) const;
  bool read(const std::string& path, std::string& value) const;

  /// State, number of steps and the policy's memory: running on from a snapshot repeats what followed it.
  class Snapshot {
   public:
    ~Snapshot();
    Snapshot(Snapshot&&) noexcept;
    Snapshot& operator=(Snapshot&&) noexcept;

   private:
    friend class Execution;
    Snapshot();
    struct Impl;
    std::unique_ptr<Impl> impl_;
  };
  [[nodiscard]] Snapshot snapshot() const;
  void restore(const Snapshot& snapshot);

  /// Empty, or the fault's text.
  [[nodiscard]] std::string fault() const;
  /// Why the state is a deadlock; empty if it is none.
  [[nodiscard]] std::string story() const;

 private:
  struct Impl;
  struct TraceFile;
  std::unique_ptr<Impl> impl_;
};

}  // namespace bip
