// What a run writes: see output.hpp.
#include "runtime/engine/output.hpp"

#include "bip/assert.hpp"
#include "runtime/core/deadlock_explanation.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/core/text.hpp"
#include "runtime/engine/policies.hpp"
#include "runtime/engine/timed_scheduler.hpp"

namespace bip::rt {

namespace {

constexpr std::size_t kPiece = 1 << 16;

}  // namespace

TraceHead head_of(const Image& image, const RunOptions& options, std::uint64_t seed) {
  const PolicyRow& policy = row_of(options.policy);
  return {.image = &image,
          .seed = seed,
          .policy = policy.name,
          .is_uniform = policy.is_uniform(),
          .engine = options.engine,
          .maximal_progress = options.maximal_progress,
          .draws_resumes = draws_resumes(image, options),
          .is_interactive = options.interactive};
}

Output::Output(const RunOptions& options, std::uint64_t seed, std::FILE* out, RunFile& trace, const Image& image)
    : options_(options),
      format_(row_of(options.format)),
      head_(head_of(image, options, seed)),
      out_file_(out),
      trace_file_(trace),
      to_trace_(trace.is_open()),
      image_calls_cpp_(image.ffi != nullptr),
      sink_(format_.make()),
      console_sink_(format_.console == Console::Steps ? format_.make() : nullptr) {}

void Output::begin() {
  BIP_ASSERT(sink_ != nullptr && (console_sink_ != nullptr) == (format_.console == Console::Steps), "format `{}`",
             format_.name);
  if (is_everything()) {
    write_both([&](std::string& text) { sink_->begin(text, head_); });
    if (options_.silent) step_lines_.begin(out_.text, head_);
  } else {
    step_lines_.begin(out_.text, head_);
    if (to_trace_) sink_->begin(trace_.text, head_);
  }
  flush();
}

void Output::foresee(Core& core) {
  if (core.is_timed() && !options_.interactive && writes_steps()) sink_->foresee(core);
}

void Output::list(Core& core, std::uint64_t number) {
  if (is_everything()) {
    write_both([&](std::string& text) { sink_->state(text, core, number); });
    if (options_.silent) sink_->state(out_.text, core, number);
  } else {
    out_.text += "state ";
    append_number(out_.text, number);
    out_.text += ":\n";
    step_lines_.state(out_.text, core);
  }
  flush();
}

void Output::append_step(std::string& out, std::string& trace, Core& core, EnabledSet::Position at,
                         std::uint64_t number, std::uint64_t k) {
  switch (format_.console) {
    case Console::Everything:
      if (!options_.silent) sink_->step(out, core, at, number, k);
      break;
    case Console::Steps:
      if (!options_.silent) console_sink_->step(out, core, at, number, k);
      break;
    case Console::StepLines:
      if (options_.debug && !options_.interactive) step_lines_.state(out, core);
      if (!options_.silent) step_lines_.step(out, core, core.candidate(at), number);
      break;
  }
  BIP_ASSERT(core.enabled().has(at), "interaction {} is no candidate", at.interaction);
  if (to_trace_) sink_->step(trace, core, at, number, k);
}

// A failure stays in the file's state: the program reports it at its end (bip/process.hpp).
void Output::drain_out(std::size_t threshold) {
  out_.drain(threshold, [this](std::string_view text) { std::fwrite(text.data(), 1, text.size(), out_file_); });
}

void Output::drain_trace(std::size_t threshold) {
  trace_.drain(threshold, [this](std::string_view text) { trace_file_.write(text); });
}

void Output::drain() {
  // What C++ prints comes after the line of its step, and C++ that crashes takes no step with it.
  drain_out(image_calls_cpp_ ? 0 : kPiece);
  if (image_calls_cpp_) std::fflush(out_file_);
  drain_trace(image_calls_cpp_ ? 0 : kPiece);
}

// A run against the clock is watched: its lines are shown when their steps happen.
void Output::drain_timed() {
  drain();
  if (options_.speed > 0) flush();
}

void Output::step(Core& core, EnabledSet::Position at, std::uint64_t number, std::uint64_t k) {
  append_step(out_.text, trace_.text, core, at, number, k);
  if (core.is_timed()) drain_timed();
  else drain();
}

void Output::describe(StepText& text, Core& core, EnabledSet::Position at, std::uint64_t number, std::uint64_t k) {
  append_step(text.out, text.trace, core, at, number, k);
}

void Output::put(const StepText& text) {
  out_.text += text.out;
  trace_.text += text.trace;
  drain();
}

void Output::put_of_node(StepText& text, const std::string& node) {
  const auto add_member = [&node](std::string& line) {
    if (!line.ends_with("}\n")) return;
    line.resize(line.size() - 2);
    line += ",\"node\":";
    append_quoted(line, node.c_str());
    line += "}\n";
  };
  if (format_.console == Console::Steps) add_member(text.out);
  else if (text.out.ends_with('\n')) text.out.insert(text.out.size() - 1, "  @" + node);
  if (format_.format == TraceFormat::Steps || format_.format == TraceFormat::Json) add_member(text.trace);
  put(text);
}

void Output::record(const std::vector<InteractionId>& interactions) {
  BIP_ASSERT(records_only(), "interactions alone are not enough for the format `{}`", format_.name);
  sink_->steps(trace_.text, interactions);
  drain_trace(kPiece);
}

void Output::end(const Core& core, End how, std::uint64_t number) {
  if (is_everything()) write_both([&](std::string& text) { sink_->end(text, core, how, number); });
  else if (to_trace_) sink_->end(trace_.text, core, how, number);
  if (!is_everything() || options_.silent) append_end(core, how, number);
  flush();
  if (to_trace_) drain_trace(0);
}

void Output::append_end(const Core& core, End how, std::uint64_t number) {
  switch (how) {
    case End::Limit: out_.text += "limit: "; break;
    case End::Interrupted: out_.text += "interrupted: "; break;
    case End::Deadlock: out_.text += deadlock_story(core, number, head_.seed); return;
    case End::Final: out_.text += final_line(number, head_.seed); return;
    case End::Fault: return;
  }
  append_number(out_.text, number);
  out_.text += number == 1 ? " step\n" : " steps\n";
}

}  // namespace bip::rt
