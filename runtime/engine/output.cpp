// What a run writes: see output.hpp.
#include "runtime/engine/output.hpp"

#include "runtime/core/deadlock_explanation.hpp"
#include "runtime/core/text.hpp"

namespace bip::rt {

namespace {

constexpr std::size_t kPiece = 1 << 16;

}  // namespace

void Output::begin(const Image& image) {
  if (bip2_format()) {
    in_bip2([&](std::string& text) { bip2_.begin(text, seed_, options_.policy); });
    if (options_.silent) steps_.begin(out_.text, seed_, options_.policy);
  } else {
    steps_.begin(out_.text, seed_, options_.policy);
    if (to_trace_) told_.begin(trace_.text, image);
  }
  out_.flush();
}

void Output::foresee(Core& core) {
  if (core.is_timed() && bip2_format() && !options_.interactive && writes_steps()) bip2_.foresee(core);
}

void Output::list(Core& core, std::uint64_t number) {
  if (bip2_format()) {
    in_bip2([&](std::string& text) { bip2_.state(text, core, number); });
    if (options_.silent) bip2_.state(out_.text, core, number);
  } else {
    out_.text += "state ";
    append_number(out_.text, number);
    out_.text += ":\n";
    steps_.state(out_.text, core);
  }
  out_.flush();
}

void Output::append_step(std::string& out, std::string& trace, Core& core, EnabledSet::Position at,
                         std::uint64_t number, std::uint64_t k) {
  const Candidate candidate = core.candidate(at);
  if (bip2_format()) {
    in_bip2([&](std::string& text) {
      if (core.is_timed() && !options_.interactive) return bip2_.foreseen(text, core, number, candidate);
      if (!options_.interactive) bip2_.state(text, core, number);
      bip2_.choice(text, core, k);
    });
    return;
  }
  if (options_.format == TraceFormat::Json) {
    if (!options_.silent) json_.step(out, core, candidate, number, k);
  } else {
    if (options_.debug && !options_.interactive) steps_.state(out, core);
    if (!options_.silent) steps_.step(out, core, candidate, number);
  }
  if (to_trace_) told_.step(trace, core, at, number, k);
}

void Output::drain(bool is_timed) {
  // What C++ prints comes after the line of its step.
  out_.drain(image_calls_cpp_ ? 0 : kPiece);
  if (is_timed && options_.speed > 0) out_.flush();
  trace_.drain(kPiece);
}

void Output::step(Core& core, EnabledSet::Position at, std::uint64_t number, std::uint64_t k) {
  append_step(out_.text, trace_.text, core, at, number, k);
  drain(core.is_timed());
}

void Output::describe(StepText& text, Core& core, EnabledSet::Position at, std::uint64_t number, std::uint64_t k) {
  append_step(text.out, text.trace, core, at, number, k);
}

void Output::put(const StepText& text) {
  out_.text += text.out;
  trace_.text += text.trace;
  drain(false);
}

void Output::record(const std::vector<u32>& interactions) {
  for (const u32 interaction : interactions) append_recorded_step(trace_.text, {interaction, 0});
  trace_.drain(kPiece);
}

void Output::end(const Core& core, End how, std::uint64_t number) {
  if (bip2_format()) {
    in_bip2([&](std::string& text) {
      if (how == End::Fault) bip2_.fault(text, core);
      bip2_.end(text, core, how, number);
    });
  } else if (to_trace_) {
    told_.end(trace_.text, core, how, number);
  }
  if (!bip2_format() || options_.silent) tell_end(core, how, number);
  out_.flush();
  if (to_trace_) trace_.flush();
}

void Output::tell_end(const Core& core, End how, std::uint64_t number) {
  switch (how) {
    case End::Limit: out_.text += "limit: "; break;
    case End::Interrupted: out_.text += "interrupted: "; break;
    case End::Deadlock: out_.text += deadlock_story(core, number, seed_); return;
    case End::Fault: return;
  }
  append_number(out_.text, number);
  out_.text += number == 1 ? " step\n" : " steps\n";
}

}  // namespace bip::rt
