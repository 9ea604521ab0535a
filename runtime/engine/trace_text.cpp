// A run's trace by format: see trace_text.hpp.
#include "runtime/engine/trace_text.hpp"

namespace bip::rt {

void TraceText::begin(std::string& out, const Image& image) {
  switch (options_.format) {
    case TraceFormat::Binary:
      return append_recorded_begin(out,
                                   {image.name, seed_, options_.policy, options_.engine, options_.maximal_progress});
    case TraceFormat::Mcap: return mcap_.begin(out, image, seed_, options_.policy);
    case TraceFormat::Perfetto: return perfetto_.begin(out, image, seed_, options_.policy);
    default: return json_.begin(out, image, seed_, options_.policy, options_.engine);
  }
}

void TraceText::step(std::string& out, Core& core, EnabledSet::Position at, std::uint64_t number, std::uint64_t k) {
  switch (options_.format) {
    case TraceFormat::Binary: return append_recorded_step(out, at);
    case TraceFormat::Mcap: return mcap_.step(out, core, core.candidate(at), number);
    case TraceFormat::Perfetto: return perfetto_.step(out, core, core.candidate(at), number);
    default: return json_.step(out, core, core.candidate(at), number, k);
  }
}

void TraceText::end(std::string& out, const Core& core, End how, std::uint64_t number) {
  switch (options_.format) {
    case TraceFormat::Binary: return append_recorded_end(out, core, how, number);
    case TraceFormat::Mcap: return mcap_.end(out, core, how, number);
    case TraceFormat::Perfetto: return perfetto_.end(out, core, how, number);
    default: return json_.end(out, core, how, number);
  }
}

}  // namespace bip::rt
