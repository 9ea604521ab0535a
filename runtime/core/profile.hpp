// Where the time of a run goes: each interaction's steps and each piece of code's calls, counted and measured.
//
// A Profile puts itself between the core and the image's code: it takes the rows of code over and measures what it
// passes on. The engine tells it where a step begins and ends. Counts are exact. Times are those of the processor's own
// counter where there is one; what measuring itself costs is measured once and taken off. A run without a Profile does
// not know of it.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "bip/image.hpp"
#include "runtime/core/link/tables.hpp"

namespace bip::rt {

/// All interactions that one declaration of the model makes.
struct InteractionProfile {
  std::string name;  // "ROOT.table.take[*]"; one instance: its path
  SourceLine loc;
  std::uint32_t connector_type = kNone;  // kNone: an internal port
  std::uint32_t atom_type = kNone, port = kNone;
  std::uint64_t instances = 0;
  std::uint64_t steps = 0;
  std::uint64_t ticks = 0, code_calls = 0, code_ticks = 0;
};
struct CodeProfile {
  std::uint64_t calls = 0;
  std::uint64_t holds = 0;  // a guard's that were true
  std::uint64_t ticks = 0;
};

class Profile {
 public:
  /// Takes over the rows, which belong to the image that will run, until it is destroyed.
  explicit Profile(std::vector<Code>& codes);
  ~Profile();
  Profile(const Profile&) = delete;
  Profile& operator=(const Profile&) = delete;

  /// The initial state is known, the first step comes.
  void start(const Tables& tables);
  void begin_step() {
    code_calls_ = code_ticks_ = 0;
    step_began_ = ticks_now();
  }
  void end_step(InteractionId interaction) {
    const std::uint64_t took = ticks_now() - step_began_;
    InteractionProfile& row = interactions_[interaction_of_[interaction]];
    ++row.steps;
    row.ticks += took;
    row.code_calls += code_calls_;
    row.code_ticks += code_ticks_;
  }
  /// `seconds` have passed since `start`.
  void finish(double seconds);

  // ---- results, in seconds, without what measuring cost
  [[nodiscard]] const std::vector<InteractionProfile>& interactions() const { return interactions_; }
  /// The row of interactions() that counts the interaction.
  [[nodiscard]] std::uint32_t row_of(InteractionId interaction) const { return interaction_of_[interaction]; }
  [[nodiscard]] const CodeProfile& code(std::size_t row) const { return rows_[row].count; }
  [[nodiscard]] double seconds_of(const InteractionProfile& row) const;
  [[nodiscard]] double code_seconds_of(const InteractionProfile& row) const;
  [[nodiscard]] double seconds_of(const CodeProfile& row) const;
  /// The run's, and the part of it that measuring took, which the others do not contain.
  [[nodiscard]] double seconds() const { return seconds_; }
  [[nodiscard]] double measuring_seconds() const;

 private:
  struct Row {
    Code code;
    Profile* owner = nullptr;
    CodeProfile count;
  };
  static std::int32_t call(const void* context, Cell* self, Cell* all, const std::uint32_t* bind);
  static std::uint64_t ticks_now();
  void calibrate();
  [[nodiscard]] double in_seconds(double ticks) const { return ticks > 0 ? ticks * seconds_per_tick_ : 0; }

  std::vector<Code>& codes_;
  std::vector<Row> rows_;
  IndexVector<InteractionId, std::uint32_t> interaction_of_;  // row of interactions_
  std::vector<InteractionProfile> interactions_;
  std::uint64_t started_ = 0, step_began_ = 0;
  std::uint64_t code_calls_ = 0, code_ticks_ = 0;  // of the step at hand
  double seconds_ = 0, seconds_per_tick_ = 0;
  // Ticks that a measured piece shows although it does nothing, and those that its caller sees.
  double shown_ = 0, cost_ = 0;
};

#if defined(__x86_64__)
inline std::uint64_t Profile::ticks_now() { return __builtin_ia32_rdtsc(); }
#endif

}  // namespace bip::rt
