// What a run writes: lines on standard output, a trace in a file, in the formats that were asked for; one of a run.
//
// With nothing to write no string is built. A step is written in the state before it. Engines that take steps in
// another order than they write them ask for the text of a step (`describe`) and hand it in later (`put`).
#pragma once
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "bip/run.hpp"
#include "runtime/engine/run_file.hpp"
#include "runtime/trace/trace.hpp"
#include "runtime/trace/trace_formats.hpp"

namespace bip::rt {

/// Text on its way to a file, written in large pieces: whole multiples of the threshold, since a file's pages that are
/// written in two goes cost the kernel twice as much.
class Sink {
 public:
  std::string text;
  /// Calls write(std::string_view) with what exceeds the threshold.
  template <class Write>
  void drain(std::size_t threshold, const Write& write) {
    if (text.size() <= threshold) return;
    const std::size_t whole = threshold == 0 ? text.size() : text.size() / threshold * threshold;
    write(std::string_view(text).substr(0, whole));
    text.erase(0, whole);
  }
};

/// A step's text for both places.
struct StepText {
  std::string out, trace;
};

class Output {
 public:
  /// A trace is written if its file is open. `options` and the files must outlive the output.
  Output(const RunOptions& options, std::uint64_t seed, std::FILE* out, RunFile& trace, const Image& image);

  [[nodiscard]] bool writes_steps() const { return !options_.silent || options_.debug || to_trace_; }
  /// The only thing written about steps is a trace to which interactions are enough.
  [[nodiscard]] bool records_only() const {
    return options_.silent && !options_.debug && to_trace_ && format_.needs_only_interactions;
  }
  void begin();
  /// Looks at what can be chosen now or later, before time passes, for formats that show it.
  void foresee(Core& core);
  /// Writes what can be chosen, for a person who chooses next.
  void list(Core& core, std::uint64_t number);
  /// k: the candidate's number; kNoChoice: this engine does not know.
  void step(Core& core, EnabledSet::Position at, std::uint64_t number, std::uint64_t k);
  /// The same as text, without writing it.
  void describe(StepText& text, Core& core, EnabledSet::Position at, std::uint64_t number, std::uint64_t k);
  void put(const StepText& text);
  /// Of a step that this node began; text formats tell it.
  void put_of_node(StepText& text, const std::string& node);
  /// Writes interactions that the core fired. Requires records_only().
  void record(const std::vector<InteractionId>& interactions);
  void end(const Core& core, End how, std::uint64_t number);
  /// Without an end.
  void flush() {
    drain_out(0);
    std::fflush(out_file_);
  }

 private:
  // Calls write(text) for standard output and for the trace, where both have the same text.
  template <class Write>
  void write_both(const Write& write) {
    if (!options_.silent) write(out_.text);
    if (to_trace_) write(trace_.text);
  }
  [[nodiscard]] bool is_everything() const { return format_.console == Console::Everything; }
  void append_step(std::string& out, std::string& trace, Core& core, EnabledSet::Position at, std::uint64_t number,
                   std::uint64_t k);
  void append_end(const Core& core, End how, std::uint64_t number);
  void drain();
  void drain_timed();
  void drain_out(std::size_t threshold);
  void drain_trace(std::size_t threshold);

  const RunOptions& options_;
  const TraceFormatRow& format_;
  TraceHead head_;
  std::FILE* out_file_;
  RunFile& trace_file_;
  Sink out_;
  Sink trace_;
  bool to_trace_;
  bool image_calls_cpp_;
  StepWriter step_lines_{};
  std::unique_ptr<TraceSink> sink_;          // of the trace; if everything is in the format, of both
  std::unique_ptr<TraceSink> console_sink_;  // Console::Steps: of standard output
};

/// Returns what a trace says of a run before its first step.
[[nodiscard]] TraceHead head_of(const Image& image, const RunOptions& options, std::uint64_t seed);

}  // namespace bip::rt
