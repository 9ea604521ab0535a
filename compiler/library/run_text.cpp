// See run_text.hpp.
#include "compiler/library/run_text.hpp"

#include <fmt/format.h>

#include "runtime/core/core.hpp"
#include "runtime/trace/trace.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::library {

namespace {

std::string ordinal_steps(std::size_t first, std::size_t last) {
  return first == last ? fmt::format("step #{} repeats for ever", first)
                       : fmt::format("the steps #{} to #{} repeat for ever", first, last);
}

}  // namespace

std::string steps_text(const rt::Image& image, const ShownRun& run, std::size_t max_lines) {
  rt::Core core(image);
  std::string text;
  rt::StepWriter writer;
  bool is_sound = core.initialize();
  const std::size_t size = run.choices.size();
  BIP_ASSERT(run.cycle <= size, "step {} of {} begins the cycle", run.cycle, size);
  std::size_t hidden = 0;
  for (std::size_t at = 0; at < size && is_sound; ++at) {
    // Of a long stem the first steps, of a long cycle, too.
    const bool is_shown = at < max_lines || (at >= run.cycle && at < run.cycle + max_lines);
    if (hidden != 0 && (is_shown || at == run.cycle)) {
      text += "… and " + rt::counted(hidden, "more step") + '\n';
      hidden = 0;
    }
    if (at == run.cycle) text += ordinal_steps(at, size - 1) + ":\n";
    if (is_shown) writer.step(text, core, core.candidate(run.choices[at]), at);
    else ++hidden;
    is_sound = core.fire(run.choices[at]);
  }
  if (hidden != 0) text += "… and " + rt::counted(hidden, "more step") + '\n';
  if (run.has_ended) text += "no step is possible any more: the last state repeats for ever\n";
  return text;
}

}  // namespace bip::library
