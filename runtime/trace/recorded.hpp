// Binary traces (`--trace-format=binary`): which interaction was fired in each step, a byte or two each, and a digest
// of the last state. Everything else follows from the model, so `bipc replay --recorded` shows such a run in any other
// format, and checks it.
//
// Version 2: "BIPTRC2\n", then numbers as LEB128 and texts as length and bytes: flags (1: maximal progress; 2: of a
// model with time; 4: the instants at which its busy atoms resume are drawn), name of the policy, name of the engine,
// seed, the root's name; a step is 1 + (interaction * 2 + (1 if a rank among the interaction's candidates follows)),
// with time followed by its instant; the end is 0, how it ended, the number of steps, with time the instant, digest (8
// bytes; 0: none). Version 1 had the policy as a number of two bits; such files are refused by name.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "bip/run.hpp"
#include "runtime/core/core.hpp"
#include "runtime/trace/trace_formats.hpp"

namespace bip::rt {

struct RecordedBegin {
  std::string name;    // of the root
  std::string policy;  // its name; any text
  std::uint64_t seed = 0;
  Engine engine = Engine::Sequential;
  bool maximal_progress = true;
  bool has_time = false;
  bool draws_resumes = false;
};
struct RecordedEnd {
  End how = End::Limit;
  std::uint64_t steps = 0, digest = 0;
};

class RecordedWriter final : public TraceSink {
 public:
  void begin(std::string& out, const TraceHead& head) override;
  void step(std::string& out, Core& core, EnabledSet::Position position, std::uint64_t number,
            std::uint64_t k) override;
  void steps(std::string& out, const std::vector<InteractionId>& interactions) override;
  void end(std::string& out, const Core& core, End end, std::uint64_t steps) override;
};

/// Returns a digest of markings and data; strings by their text, NaN without payload, objects of C++ types left out.
/// Never 0. Linear in the state.
[[nodiscard]] std::uint64_t digest_of(const Core& core);

class RecordedReader {
 public:
  /// Reads the head of a trace. The bytes must outlive the reader. Returns an empty text, or why they are no trace that
  /// it can read: other bytes, another version, cut off.
  [[nodiscard]] std::string open(std::string_view bytes, RecordedBegin& begin);
  enum class Next : std::uint8_t { Step, End, Cut };
  /// Reads a step into `position`, or the end into `end`. Cut: the bytes end before.
  Next next(EnabledSet::Position& position, RecordedEnd& end);
  /// With time: of the step or of the end that was read last.
  [[nodiscard]] i64 instant() const { return instant_; }
  /// After Next::End: bytes that follow the trace.
  [[nodiscard]] std::size_t rest() const { return bytes_.size() - at_; }

 private:
  bool number(std::uint64_t& value);
  bool text(std::string& value);
  bool engine(Engine& value);
  bool read_instant();
  std::string_view bytes_;
  std::size_t at_ = 0;
  bool has_time_ = false;
  i64 instant_ = 0;
};

}  // namespace bip::rt
