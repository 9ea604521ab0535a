// The text of a run's trace in the format that was asked for, all but bip2: that one lists what each state offers
// (output.hpp).
//
// A step is told in the state before it. Each call appends to `out`, or keeps something for later (MCAP's chunks): what
// was appended since begin(), in this order, is the file.
#pragma once
#include <string>

#include "bip/run.hpp"
#include "runtime/trace/mcap.hpp"
#include "runtime/trace/perfetto.hpp"
#include "runtime/trace/recorded.hpp"
#include "runtime/trace/trace.hpp"

namespace bip::rt {

class TraceText {
 public:
  /// options: lives as long as this.
  TraceText(const RunOptions& options, std::uint64_t seed) : options_(options), seed_(seed) {}
  void begin(std::string& out, const Image& image);
  /// k: the candidate's number; kNoChoice: the engine does not know.
  void step(std::string& out, Core& core, EnabledSet::Position at, std::uint64_t number, std::uint64_t k);
  void end(std::string& out, const Core& core, End how, std::uint64_t number);

 private:
  const RunOptions& options_;
  std::uint64_t seed_;
  JsonWriter json_{};
  McapWriter mcap_{};
  PerfettoWriter perfetto_{};
};

}  // namespace bip::rt
