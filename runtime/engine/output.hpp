// What a run writes: lines on standard output, a trace in a file, in the formats that were asked for; one of a run.
//
// With nothing to write no string is built. A step is written in the state before it. Engines that take steps in
// another order than they write them ask for the text of a step (`describe`) and hand it in later (`put`).
#pragma once
#include <cstdio>
#include <string>

#include "bip/run.hpp"
#include "runtime/engine/trace_text.hpp"

namespace bip::rt {

/// Text on its way to a file, written in large pieces: whole multiples of the threshold, since a file's pages that are
/// written in two goes cost the kernel twice as much.
class Sink {
 public:
  explicit Sink(std::FILE* file) : file_(file) {}
  std::string text;
  void drain(std::size_t threshold) {
    if (text.size() <= threshold) return;
    const std::size_t whole = threshold == 0 ? text.size() : text.size() / threshold * threshold;
    std::fwrite(text.data(), 1, whole, file_);
    text.erase(0, whole);
  }
  void flush() {
    drain(0);
    std::fflush(file_);
  }

 private:
  std::FILE* file_;
};

/// A step's text for both places.
struct StepText {
  std::string out, trace;
};

class Output {
 public:
  /// trace: null if none is written.
  Output(const RunOptions& options, std::uint64_t seed, std::FILE* out, std::FILE* trace, const Image& image)
      : options_(options),
        seed_(seed),
        out_(out),
        trace_(trace),
        to_trace_(trace != nullptr),
        image_calls_cpp_(image.ffi != nullptr),
        told_(options, seed) {}

  [[nodiscard]] bool writes_steps() const { return !options_.silent || options_.debug || to_trace_; }
  [[nodiscard]] bool bip2_format() const { return options_.format == TraceFormat::Bip2; }
  /// The only thing written about steps is the binary trace: interactions are all it needs.
  [[nodiscard]] bool records_only() const { return options_.silent && !options_.debug && records(); }
  void begin(const Image& image);
  /// What can be chosen now or later, before time passes.
  void foresee(Core& core);
  /// What can be chosen, for a person who is asked next.
  void list(Core& core, std::uint64_t number);
  /// k: the candidate's number; kNoChoice: this engine does not know.
  void step(Core& core, EnabledSet::Position at, std::uint64_t number, std::uint64_t k);
  /// The same as text, without writing it.
  void describe(StepText& text, Core& core, EnabledSet::Position at, std::uint64_t number, std::uint64_t k);
  void put(const StepText& text);
  /// records_only(): the last `count` interactions that the core fired.
  void record(const std::vector<u32>& interactions);
  void end(const Core& core, End how, std::uint64_t number);
  /// Without an end.
  void flush() { out_.flush(); }

 private:
  [[nodiscard]] bool records() const { return to_trace_ && options_.format == TraceFormat::Binary; }
  // Calls write(text) for standard output and for the trace, where both have the bip2 format.
  template <class Write>
  void in_bip2(const Write& write) {
    if (!options_.silent) write(out_.text);
    if (to_trace_) write(trace_.text);
  }
  void append_step(std::string& out, std::string& trace, Core& core, EnabledSet::Position at, std::uint64_t number,
                   std::uint64_t k);
  void tell_end(const Core& core, End how, std::uint64_t number);
  void drain(bool is_timed);

  const RunOptions& options_;
  std::uint64_t seed_;
  Sink out_;
  Sink trace_;
  bool to_trace_;
  bool image_calls_cpp_;
  StepWriter steps_{};
  Bip2Writer bip2_{};
  JsonWriter json_{};
  TraceText told_;
};

}  // namespace bip::rt
