// Traces for ui.perfetto.dev and chrome://tracing: the Trace Event Format in JSON (Google, "Trace Event Format", 2016),
// a track a component.
//
// A slice of a component's track is the time it spends in a place, an arrow-head the port that fires, with its values;
// the first track has the interactions. Instants are the model's, in us with three decimals (without time a millisecond
// a step), so the same run gives the same bytes. Memory: an instant and a place an atom.
#pragma once
#include <string>
#include <vector>

#include "bip/run.hpp"
#include "runtime/core/core.hpp"
#include "runtime/trace/trace_formats.hpp"

namespace bip::rt {

class PerfettoWriter final : public TraceSink {
 public:
  void begin(std::string& out, const TraceHead& head) override;
  void step(std::string& out, Core& core, EnabledSet::Position position, std::uint64_t number,
            std::uint64_t k) override;
  void end(std::string& out, const Core& core, End end, std::uint64_t steps) override;

 private:
  void stay(std::string& out, const Core& core, u32 atom, i64 until);

  std::vector<i64> since_;  // by atom: when it came to where it is
  std::string name_;        // scratch
  std::vector<Participant> participants_;
};

}  // namespace bip::rt
