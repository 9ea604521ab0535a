// The formats of traces. This table is the only one: the command line, emitted programs, runs, explorations and
// embedding programs find formats here.
//
// A new format is a value of TraceFormat (bip/run.hpp), a TraceSink and a row in trace_formats.cpp.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bip/run.hpp"
#include "runtime/core/core.hpp"

namespace bip::rt {

/// What a trace says of its run before the first step.
struct TraceHead {
  const Image* image = nullptr;
  std::uint64_t seed = 0;
  std::string_view policy;  // its name
  bool is_uniform = false;  // the policy draws by the seed
  Engine engine = Engine::Sequential;
  bool maximal_progress = true;
  bool draws_resumes = false;   // the instants at which busy atoms resume, by the seed
  bool is_interactive = false;  // each state is written by state() before its step
};

/// Writes one trace. Each call appends to `out`, or keeps something for later: what was appended since begin(), in this
/// order, is the file. A step is written in the state before it; nothing depends on the clock.
class TraceSink {
 public:
  virtual ~TraceSink() = default;
  virtual void begin(std::string& out, const TraceHead& head) = 0;
  /// Looks at what can be chosen now or later, before time passes. In models with time, once per state.
  virtual void foresee(Core& core) { (void)core; }
  /// Writes the state's candidates, for a person who chooses next. Only formats whose Console is Everything.
  virtual void state(std::string& out, Core& core, std::uint64_t number) { (void)out, (void)core, (void)number; }
  /// k: the candidate's number; kNoChoice: the engine does not know it.
  virtual void step(std::string& out, Core& core, EnabledSet::Position position, std::uint64_t number,
                    std::uint64_t k) = 0;
  /// Writes steps of which nothing but their interactions is known. Only formats with `needs_only_interactions`.
  virtual void steps(std::string& out, const std::vector<InteractionId>& interactions) {
    (void)out, (void)interactions;
  }
  virtual void end(std::string& out, const Core& core, End end, std::uint64_t steps) = 0;
};

/// What standard output has in a run with the format: our step lines; our first and last line, and the format's steps
/// between them; the same as the trace.
enum class Console : std::uint8_t { StepLines, Steps, Everything };
/// Engines whose runs the format can show. OneByOne: those that know the candidates of each state they leave.
enum class TracedEngines : std::uint8_t { All, OneByOne, Sequential };

struct TraceFormatRow {
  TraceFormat format;
  const char* name;  // on the command line
  const char* help;  // follows the name in --help; empty: the name says it all
  std::unique_ptr<TraceSink> (*make)();
  Console console = Console::StepLines;
  TracedEngines engines = TracedEngines::All;
  bool has_outside = true;               // what comes from outside: events, returns of actions in real time
  bool needs_file = false;               // it makes no sense without --trace
  bool is_text = false;                  // explorations and replays can be shown in it
  bool can_embed = false;                // Execution::trace writes it
  bool needs_only_interactions = false;  // steps() is enough
};

/// Returns all formats, in the order of the enum; the first is the default.
[[nodiscard]] std::span<const TraceFormatRow> trace_formats();
[[nodiscard]] const TraceFormatRow& row_of(TraceFormat format);
/// Returns the format of this name, or null.
[[nodiscard]] const TraceFormatRow* find_trace_format(std::string_view name);

}  // namespace bip::rt
