// The table of trace formats: see trace_formats.hpp.
#include "runtime/trace/trace_formats.hpp"

#include <algorithm>

#include "bip/assert.hpp"
#include "runtime/trace/mcap.hpp"
#include "runtime/trace/perfetto.hpp"
#include "runtime/trace/recorded.hpp"
#include "runtime/trace/trace.hpp"

namespace bip::rt {

namespace {

template <class Writer>
std::unique_ptr<TraceSink> make_sink() {
  return std::make_unique<Writer>();
}

constexpr TraceFormatRow kTraceFormatRows[] = {
    // The file of a run with step lines has JSON lines.
    {.format = TraceFormat::Steps, .name = "steps", .help = "", .make = make_sink<JsonWriter>, .is_text = true},
    {.format = TraceFormat::Json,
     .name = "json",
     .help = "",
     .make = make_sink<JsonWriter>,
     .console = Console::Steps,
     .is_text = true,
     .can_embed = true},
    {.format = TraceFormat::Bip2,
     .name = "bip2",
     .help = "is the text of the reference engine",
     .make = make_sink<Bip2Writer>,
     .console = Console::Everything,
     .engines = TracedEngines::OneByOne,
     .is_text = true},
    {.format = TraceFormat::Binary,
     .name = "binary",
     .help = "is read by `bipc replay`",
     .make = make_sink<RecordedWriter>,
     .has_outside = false,
     .needs_only_interactions = true},
    {.format = TraceFormat::Mcap,
     .name = "mcap",
     .help = "is read by Foxglove",
     .make = make_sink<McapWriter>,
     .engines = TracedEngines::Sequential,
     .needs_file = true,
     .can_embed = true},
    {.format = TraceFormat::Perfetto,
     .name = "perfetto",
     .help = "is read by ui.perfetto.dev",
     .make = make_sink<PerfettoWriter>,
     .engines = TracedEngines::Sequential,
     .needs_file = true,
     .can_embed = true},
};

constexpr bool are_formats_in_order() {
  for (std::size_t k = 0; k < std::size(kTraceFormatRows); ++k) {
    if (static_cast<std::size_t>(kTraceFormatRows[k].format) != k) return false;
  }
  return true;
}
static_assert(are_formats_in_order(), "rows are found by the number of their format");

}  // namespace

std::span<const TraceFormatRow> trace_formats() { return kTraceFormatRows; }

const TraceFormatRow& row_of(TraceFormat format) {
  BIP_ASSERT(static_cast<std::size_t>(format) < std::size(kTraceFormatRows), "format {}", format);
  return kTraceFormatRows[static_cast<std::size_t>(format)];
}

const TraceFormatRow* find_trace_format(std::string_view name) {
  const auto* const row = std::find_if(std::begin(kTraceFormatRows), std::end(kTraceFormatRows),
                                       [&](const TraceFormatRow& candidate) { return candidate.name == name; });
  return row == std::end(kTraceFormatRows) ? nullptr : row;
}

}  // namespace bip::rt
