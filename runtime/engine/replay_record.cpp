// Following a binary trace: see replay_record.hpp.
#include "runtime/engine/replay_record.hpp"

#include <algorithm>
#include <cstdlib>

#include "bip/assert.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/core/time/time_text.hpp"
#include "runtime/engine/checkpoints.hpp"
#include "runtime/engine/node_time.hpp"
#include "runtime/engine/output.hpp"
#include "runtime/engine/policies.hpp"

namespace bip::rt {

namespace {

std::string numbered(const char* before, std::uint64_t number, const char* after) {
  return before + std::to_string(number) + after;
}

// Lets time pass to a recorded instant, unless a fault comes first. Returns why it may not; empty: it may.
std::string pass_time(Core& core, i64 instant, bool& sound) {
  if (instant < core.now()) return "the instant is before the one of the step before";
  std::vector<i64> ends;
  while (sound && core.now() != instant) {
    const i64 next = std::min(instant, core.time().next_change());
    if (const i64 last = core.time().wait_limit(ends); next > last) {
      std::string problem = "time passes ";
      append_time(problem, last);
      return problem + ", the last instant that the model allows";
    }
    sound = core.time().advance(next);
  }
  return {};
}

// What the core makes of the recorded end; empty: the same.
std::string compare_ends(Core& core, bool sound, const RecordedEnd& end, std::uint64_t steps) {
  const auto untold_fault = [&] { return "a run-time error ends the model, and not the trace: " + core.fault().what; };
  // Of the last step, which is not counted then. A node that was lost while it was at work at a step cannot tell of it.
  if (!sound && end.how != End::Fault) return untold_fault();
  if (end.steps != steps)
    return numbered("the trace has ", steps, " steps") + numbered(" and says that it has ", end.steps, "");
  if (sound && end.how != End::Limit && end.how != End::Interrupted) sound = !is_time_locked(core);
  if (end.how == End::Fault) return sound ? "the trace ends with a run-time error, the model does not" : "";
  if (!sound) return untold_fault();
  const bool goes_on = core.candidate_count() != 0 || (core.is_timed() && core.time().next_change() != kForever);
  if ((end.how == End::Deadlock || end.how == End::Final) && goes_on)
    return end.how == End::Deadlock ? "the trace ends in a deadlock, the model can go on"
                                    : "the trace ends in a final state, the model can go on";
  if (end.how == End::Final && !is_final_state(core)) return "the trace ends in a final state, the model in a deadlock";
  if (end.how == End::Deadlock && is_final_state(core))
    return "the trace ends in a deadlock, the model in a final state";
  if (end.digest != 0 && end.digest != digest_of(core)) return "the last state is another one";
  return "";
}

// Reads the head of the trace. Returns why it is none of this model; empty: it is one.
std::string open_trace(const Image& image, std::string_view bytes, RecordedReader& reader, RecordedBegin& begin) {
  if (std::string problem = reader.open(bytes, begin); !problem.empty()) return problem;
  if (find_policy(begin.policy) == nullptr) return "its policy is none of this bipc's";
  if (begin.name != image.name) return std::string("it is a run of ") + begin.name + ", not of " + image.name;
  if (begin.has_time != has_time(image))
    return begin.has_time ? "it has instants, and the model has no time" : "it has no instants, and the model has time";
  return {};
}

}  // namespace

std::string recorded_problem(const Image& image, std::string_view bytes) {
  RecordedReader reader;
  RecordedBegin begin;
  return open_trace(image, bytes, reader, begin);
}

std::string junk_problem(const RecordedReader& reader) {
  if (reader.rest() == 0) return {};
  return numbered("the end of the trace is followed by ", reader.rest(), " bytes that are no part of it");
}

Followed follow(const Image& image, std::string_view bytes, RunOptions options, std::FILE* out) {
  Followed result;
  RecordedReader reader;
  result.problem = open_trace(image, bytes, reader, result.begin);
  result.is_trace = result.problem.empty();
  if (!result.is_trace) return result;
  options.policy = find_policy(result.begin.policy)->policy;
  RunFile no_trace({}, stderr);
  Output output(options, result.begin.seed, out, no_trace, image);
  output.begin();
  Core core(image, {.progress = result.begin.maximal_progress ? MaximalProgress::On : MaximalProgress::Off});
  if (image.ffi != nullptr) std::srand(static_cast<unsigned>(result.begin.seed));
  core.seed_draws(result.begin.seed);
  if (result.begin.draws_resumes && core.is_timed()) core.time().draw_resumes(result.begin.seed);
  bool sound = core.initialize();
  if (sound && !options.resume_path.empty()) {
    Checkpoint checkpoint;
    result.problem = resume(core, options.resume_path, checkpoint);
    if (!result.problem.empty()) return result;
  }
  EnabledSet::Position at{};
  RecordedEnd end;
  while (true) {
    const RecordedReader::Next next = reader.next(at, end);
    if (core.is_timed() && sound && next != RecordedReader::Next::Cut) {
      result.problem = pass_time(core, reader.instant(), sound);
      if (!result.problem.empty()) {
        result.problem = numbered("before step ", result.steps, " ") + result.problem;
        break;
      }
    }
    if (next == RecordedReader::Next::Step) {
      if (!sound) {
        result.problem = numbered("a run-time error ends the model before step ", result.steps, " of the trace: ") +
                         core.fault().what;
        break;
      }
      if (!core.enabled().has(at)) {
        result.problem = numbered("step ", result.steps, "");
        if (core.tables().interactions.contains(at.interaction)) {
          result.problem += " takes `";
          append_candidate(result.problem, core, core.candidate({at.interaction, 0}));
          result.problem += '`';
        }
        result.problem += ", which is no candidate there";
        for (u64 k = 0; k < core.candidate_count() && k < 20; ++k) {
          result.candidates += "\n      ";
          append_candidate(result.candidates, core, core.candidate(k));
        }
        break;
      }
      if (output.writes_steps()) output.step(core, at, result.steps, core.enabled().number(at));
      BIP_ASSERT(!core.fault(), "step {} comes after a fault", result.steps);
      sound = core.is_timed() ? core.time().take(at) : core.take(at);
      if (sound) ++result.steps;
      continue;
    }
    if (next == RecordedReader::Next::Cut) {
      result.problem = numbered("the trace is cut off after ", result.steps, " steps");
    } else {
      result.problem = compare_ends(core, sound, end, result.steps);
      if (result.problem.empty()) result.problem = junk_problem(reader);
      result.end = end.how;
      output.end(core, end.how, result.steps);
      return result;
    }
    break;
  }
  output.flush();
  return result;
}

}  // namespace bip::rt
