// A part of a run in formats that other programs read: the wanted steps with their numbers and instants. Places in them
// are those of the whole run. No part can be repeated on the model.
#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "compiler/traces/selection.hpp"
#include "runtime/trace/trace_formats.hpp"

namespace bip::traces {

/// Of JSON lines: the head, the lines of wanted steps and the end.
[[nodiscard]] std::string wanted_lines(const std::string& text, const std::vector<bool>& wanted);

/// Of a Perfetto trace of the whole run: wanted steps on the tracks of the selected components, with all of their
/// places. `text` is one that bipc wrote.
[[nodiscard]] std::string wanted_events(const std::string& text, const std::vector<bool>& wanted,
                                        const Selection& selection);

/// Passes wanted steps on to another sink; for formats in which a step says nothing of others (MCAP).
class PartSink final : public rt::TraceSink {
 public:
  PartSink(rt::TraceSink& whole, std::vector<bool> wanted) : whole_(whole), wanted_(std::move(wanted)) {}
  void begin(std::string& out, const rt::TraceHead& head) override { whole_.begin(out, head); }
  void step(std::string& out, rt::Core& core, rt::EnabledSet::Position position, std::uint64_t number,
            std::uint64_t k) override {
    if (number < wanted_.size() && wanted_[static_cast<std::size_t>(number)])
      whole_.step(out, core, position, number, k);
  }
  void end(std::string& out, const rt::Core& core, rt::End end, std::uint64_t steps) override {
    whole_.end(out, core, end, steps);
  }

 private:
  rt::TraceSink& whole_;
  std::vector<bool> wanted_;
};

}  // namespace bip::traces
