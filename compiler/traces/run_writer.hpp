// Recorded runs as tables (CSV), waves (VCD, IEEE 1364-2005 clause 18, with `string` variables as GTKWave reads them)
// and sequence charts (SVG). Each gets the state at the begin and after each step, and writes of the wanted steps and
// components only. What they append, in this order, is the file.
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "compiler/system/system_ids.hpp"
#include "compiler/traces/selection.hpp"

namespace bip::traces {

enum class WrittenAs : std::uint8_t { Csv, Vcd, Chart };

class RunWriter {
 public:
  virtual ~RunWriter() = default;
  /// In the state before the first step.
  virtual void begin(std::string& out, const rt::Core& core) = 0;
  /// After a move, whether its step is wanted or not (a state changes all the same).
  enum class Wanted : std::uint8_t { No, Yes };
  virtual void step(std::string& out, const rt::Core& core, const TracedStep& step, Wanted wanted) = 0;
  virtual void end(std::string& out) = 0;
  /// Empty, or why there is no file.
  [[nodiscard]] virtual std::string problem() const { return {}; }
};

/// Both must outlive the writer.
[[nodiscard]] std::unique_ptr<RunWriter> make_run_writer(WrittenAs format, const System& system,
                                                         const Selection& selection);

/// A chart has at most so many steps.
inline constexpr std::size_t kMostChartSteps = 2000;

}  // namespace bip::traces
