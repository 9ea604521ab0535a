// `bipc replay --published TRACE FILE` compares a model with a trace of the published engine; `--recorded` checks that
// a binary trace is a run of the model, and prints it in another format (runtime/engine/replay_record.hpp).
//
// --published follows the choices of the trace with our own core and compares, state by state, the candidates as
// multisets of their printed form (names, port values and, for models with time, the intervals in which each may be
// taken). The first difference is printed with both sets. The end of the trace, if it has one, must be the model's: a
// deadlock, a time lock at the same instant, the same kind of error, in the same component and invariant where the
// trace names them. A trace whose last line is cut off in the words of an error, or that ends behind a choice, agrees
// with any error of the model there.
//
// An event from outside comes when the trace chooses its port. What the trace does not tell of events (when ports wait
// for one, values that it does not show) is not compared, and said.
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <map>

#include "compiler/base/ascii.hpp"
#include "compiler/base/read_file.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/driver/published_events.hpp"
#include "compiler/driver/published_trace.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/system/uses_time.hpp"
#include "runtime/engine/event_file.hpp"
#include "runtime/engine/replay_record.hpp"
#include "runtime/trace/trace.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::driver {
namespace {

// One candidate: how it is shown and how it is compared.
struct Shown {
  std::string text, normal;
};

std::vector<Shown> shown(const std::vector<std::string>& texts) {
  std::vector<Shown> all;
  for (const std::string& text : texts) all.push_back({text, normal_candidate(text)});
  return all;
}

// Ours, in canonical order: what the bip2 writer prints for the state.
std::vector<Shown> our_candidates(rt::Core& core, rt::Bip2Writer& writer) {
  std::string text;
  writer.state(text, core, 0);
  const Result<PublishedTrace> trace = read_published_trace(text);
  return trace && core.candidate_count() > 0 ? shown((*trace).states.front().candidates) : std::vector<Shown>();
}

// Now and later, with their intervals.
std::vector<Shown> our_future(rt::Core& core, rt::Bip2Writer& writer) {
  std::string text;
  writer.foresee(core);
  writer.future_state(text, 0);
  const Result<PublishedTrace> trace = read_published_trace(text);
  return trace && writer.has_future() ? shown((*trace).states.front().candidates) : std::vector<Shown>();
}

// Those of `a` that `b` lacks, counted.
std::vector<std::string> missing_in(const std::vector<Shown>& a, const std::vector<Shown>& b) {
  std::map<std::string, std::size_t> have;
  for (const Shown& s : b) ++have[s.normal];
  std::vector<std::string> missing;
  for (const Shown& s : a) {
    if (auto it = have.find(s.normal); it != have.end() && it->second > 0) {
      --it->second;
    } else {
      missing.push_back(s.text);
    }
  }
  return missing;
}

// Instants and intervals of a model without time say nothing: it has none.
std::vector<std::string> without_time(std::vector<std::string> candidates) {
  for (std::string& candidate : candidates) candidate = without_intervals(candidate);
  return candidates;
}

TraceEnd end_of(rt::FaultCode code) {
  switch (code) {
    case rt::FaultCode::None: return TraceEnd::None;
    case rt::FaultCode::TwoTransitions:
    case rt::FaultCode::TwoInternals: return TraceEnd::TwoTransitions;
    case rt::FaultCode::NotOneSafe: return TraceEnd::NotOneSafe;
    case rt::FaultCode::InvariantViolated: return TraceEnd::Invariant;
    case rt::FaultCode::PriorityCycle:
    case rt::FaultCode::AtomPriorityCycle: return TraceEnd::PriorityCycle;
    case rt::FaultCode::TimeLock: return TraceEnd::TimeLock;
    case rt::FaultCode::LateStep: return TraceEnd::Late;
    case rt::FaultCode::EventRefused: return TraceEnd::Event;
    case rt::FaultCode::EndlessInternals:
    case rt::FaultCode::DivisionByZero:
    case rt::FaultCode::DivisionOverflow:
    case rt::FaultCode::TooManyInteractions:
    case rt::FaultCode::Exception:
    case rt::FaultCode::BadClock:
    case rt::FaultCode::SourceFailed:
    case rt::FaultCode::ReplayDiffers:
    case rt::FaultCode::BadDraw:
    case rt::FaultCode::UntriedDraw: break;
  }
  return TraceEnd::Error;
}

std::string set_text(const std::vector<Shown>& candidates) {
  if (candidates.empty()) return " nothing (a deadlock)";
  std::string text;
  for (const Shown& s : candidates) text += "\n      " + s.text;
  return text;
}

class Replay {
 public:
  Replay(Compilation& c, const std::string& trace_path, bool maximal_progress)
      : compilation_(c),
        trace_path_(trace_path),
        core_(c.lowered->image, {.progress = maximal_progress ? rt::MaximalProgress::On : rt::MaximalProgress::Off}),
        events_(core_) {}

  // True if all states and the end agree.
  bool follow(const PublishedTrace& trace) {
    trace_ = &trace;
    if (!core_.initialize()) return fault(trace.states.empty() ? nullptr : &trace.states.front());
    if (!follow_states(trace.states)) return false;
    if (ends_with_fault_ || has_unnamed_fault_) return true;
    switch (trace.end) {
      case TraceEnd::None:
      case TraceEnd::Deadlock: return true;
      case TraceEnd::TimeLock: return ends_in_time_lock();
      case TraceEnd::Event: return refuses_event();
      // Of the clock on the wall, which a model has not.
      case TraceEnd::Late: return is_late_ = true;
      case TraceEnd::TwoTransitions:
      case TraceEnd::NotOneSafe:
      case TraceEnd::Invariant:
      case TraceEnd::PriorityCycle:
      case TraceEnd::Error:
      case TraceEnd::CutError: break;
    }
    return no_such_end();
  }
  [[nodiscard]] std::uint64_t compared() const { return compared_; }
  [[nodiscard]] std::uint64_t steps() const { return steps_; }
  /// Did the trace end with an error that the model has, too?
  [[nodiscard]] bool has_equal_end() const { return ends_with_fault_; }
  /// What the trace does not tell of events; empty: nothing.
  [[nodiscard]] std::string not_compared() const {
    std::string text;
    const auto add = [&text](const std::string& what) { text += (text.empty() ? "" : "; ") + what; };
    if (lists_event_ports_) add("the instants at which ports wait for events");
    if (without_values_ != 0)
      add(fmt::format("values of {} event{} that the trace does not show, taken as 0, false or an empty text",
                      without_values_, without_values_ == 1 ? "" : "s"));
    if (is_late_) add("the timing violation at the end");
    if (has_unnamed_fault_) add("the error at the end, which the trace does not show whole: " + core_.fault().what);
    if (has_unnamed_event_) add("the event that nothing takes, which the trace does not name");
    return text;
  }

 private:
  bool follow_states(const std::vector<TraceState>& states) {
    for (const TraceState& state : states) {
      // An event that arrives makes the engine list the state anew, at its instant.
      if (!core_.events().empty() && rt::parse_time(state.entered) > core_.now() && !pass_time(state, state.entered))
        return false;
      std::vector<Shown> ours = core_.is_timed() ? our_future(core_, writer_) : our_candidates(core_, writer_);
      if (!agrees_on_candidates(state, ours)) return false;
      ++compared_;
      if (state.chosen.empty()) continue;
      if (core_.is_timed()) {
        if (state.instant.empty())
          return fail(fmt::format("state #{} of `{}` does not say when it is left", state.number, trace_path_));
        if (!pass_time(state, state.instant)) return false;
        if (events_.find(state.chosen) != rt::kNone) {
          if (!take_event(state)) return false;
          ++steps_;
          continue;
        }
        ours = our_candidates(core_, writer_);
      }
      const std::string wanted = normal_candidate(state.chosen);
      const auto is_wanted = [&](const Shown& s) { return s.normal == wanted; };
      auto chosen = std::find_if(ours.begin(), ours.end(), is_wanted);
      for (std::size_t k = 0; k < state.chosen_rank && chosen != ours.end(); ++k) {
        const auto next = std::find_if(chosen + 1, ours.end(), is_wanted);
        if (next == ours.end()) break;
        chosen = next;
      }
      if (chosen == ours.end()) {
        return fail(core_.is_timed() ? fmt::format("state #{} of `{}` chooses at {} what is not possible then: {}",
                                                   state.number, trace_path_, state.instant, state.chosen)
                                     : fmt::format("state #{} of `{}` chooses what it does not list: {}", state.number,
                                                   trace_path_, state.chosen));
      }
      const auto k = static_cast<std::uint64_t>(chosen - ours.begin());
      if (core_.is_timed() ? !core_.time().take(core_.position(k)) : !core_.fire(k))
        return fault(&state == &states.back() ? nullptr : &state);
      ++steps_;
    }
    return true;
  }

  // The state's candidates are the model's, and ports for events that it lists can take one.
  bool agrees_on_candidates(const TraceState& state, const std::vector<Shown>& ours) {
    // The last state of a run that was cut off may lack lines.
    const bool is_cut = !state.is_complete && &state == &trace_->states.back() && state.chosen.empty();
    const auto agree = [&](const std::vector<Shown>& a, const std::vector<Shown>& b) {
      return missing_in(a, b).empty() && (is_cut || missing_in(b, a).empty());
    };
    if (core_.events().empty()) {
      const std::vector<Shown> theirs = shown(core_.is_timed() ? state.candidates : without_time(state.candidates));
      return agree(theirs, ours) || differ(state, theirs, ours);
    }
    const std::vector<Shown> theirs = without_values(shown(state.candidates)), known = without_values(ours);
    std::vector<Shown> without;       // events that the model does not have yet
    std::vector<std::string> events;  // and these
    for (const Shown& s : theirs) {
      const rt::u32 row = events_.find(s.text);
      if (row == rt::kNone || core_.events().waiting(row) != 0) without.push_back(s);
      else events.push_back(s.text);
    }
    // Ports that wait for an event, or at which one waits, which may be urgent.
    if (agree(without, known)) return events.empty() || offers_events(state, events);
    const rt::State before = core_.snapshot();
    for (const std::string& event : events) {
      // A list may leave out the values that the choice shows.
      const bool is_chosen = events_.find(state.chosen) == events_.find(event);
      if (!deliver(state, is_chosen ? state.chosen : event)) return false;
    }
    if (!events.empty() && agree(theirs, without_values(our_future(core_, writer_)))) return true;
    return core_.restore(before) ? differ(state, without, known) : fault(&state);
  }
  // Candidates that are events are compared by their ports and intervals: the values are the event's, not the model's.
  [[nodiscard]] std::vector<Shown> without_values(std::vector<Shown> candidates) const {
    for (Shown& s : candidates) {
      const rt::u32 row = events_.find(s.text);
      if (row == rt::kNone) continue;
      const std::string_view intervals = std::string_view(s.text).substr(without_intervals(s.text).size());
      s.normal = normal_candidate(fmt::format("{} {}", events_.ports().path(row), trimmed(intervals)));
    }
    return candidates;
  }
  // Would these ports take an event: those that keep events now or later? Of others only the trace's choice says at
  // which instant.
  bool offers_events(const TraceState& state, const std::vector<std::string>& listed) {
    lists_event_ports_ = true;
    for (const std::string& candidate : listed) {
      const rt::u32 row = events_.find(candidate);
      if (core_.events().ports()[row].policy != rt::EventPolicy::Remember) continue;
      const rt::State before = core_.snapshot();
      if (!deliver(state, candidate)) return false;
      const std::vector<Shown> future = our_future(core_, writer_);
      const bool takes =
          std::any_of(future.begin(), future.end(), [&](const Shown& s) { return events_.find(s.text) == row; });
      if (!core_.restore(before)) return fault(&state);
      if (!takes)
        return fail(fmt::format("state #{} of `{}`, line {}, lists port `{}`, which takes no event there", state.number,
                                trace_path_, state.line, events_.ports().path(row)));
    }
    return true;
  }
  // The event that a line shows comes at this instant.
  bool deliver(const TraceState& state, const std::string& line) {
    const Result<PublishedEvent> event = events_.read(without_intervals(line));
    if (!event) return fail(fmt::format("state #{} of `{}`: {}", state.number, trace_path_, event.error()));
    std::vector<rt::Cell> cells;
    events_.ports().to_cells((*event).row, (*event).values, cells);
    return core_.events().deliver((*event).row, cells.data()) || fault(&state);
  }
  // The port of the event that the state chooses takes it, at this instant.
  bool take_event(const TraceState& state) {
    const rt::u32 row = events_.find(state.chosen);
    BIP_ASSERT(row < core_.events().ports().size(), "`{}` is event {} of {}", state.chosen, row,
               core_.events().ports().size());
    if (core_.events().waiting(row) == 0 && !deliver(state, state.chosen)) return false;
    const Result<PublishedEvent> event = events_.read(without_intervals(state.chosen));
    without_values_ += event && (*event).shows_values ? 0 : 1;
    const rt::EventPortRow& port = core_.events().ports()[row];
    std::vector<rt::Participant> participants;
    for (std::uint64_t k = 0; k < core_.candidate_count(); ++k) {
      if (core_.candidate(k).connector != rt::kNone) continue;
      core_.participants(core_.candidate(k), participants);
      BIP_ASSERT(participants.size() == 1, "an internal port with {} participants", participants.size());
      if (participants.front().atom != port.atom || participants.front().port != port.port) continue;
      return core_.time().take(core_.position(k)) || fault(&state == &trace_->states.back() ? nullptr : &state);
    }
    return fail(fmt::format("state #{} of `{}` takes at {} an event of port `{}`, which takes none then", state.number,
                            trace_path_, state.instant, events_.ports().path(row)));
  }
  // The trace ends with an event that nothing takes: is it an error of the model, too?
  bool refuses_event() {
    const rt::u32 row = events_.find_word(trace_->end_text);
    if (row == rt::kNone) {
      has_unnamed_event_ = true;
      return events_.ports().size() != 0 || no_such_end();
    }
    const TraceState before_all, &last = trace_->states.empty() ? before_all : trace_->states.back();
    if (rt::parse_time(trace_->end_instant) > core_.now() && !pass_time(last, trace_->end_instant)) return false;
    const std::vector<rt::Cell> values(core_.events().ports()[row].width);
    if (core_.events().deliver(row, values.data())) return no_such_end();
    return core_.fault().code == rt::FaultCode::EventRefused ? agree() : fault(nullptr);
  }
  bool agree() {
    ends_with_fault_ = true;
    return true;
  }
  bool no_such_end() {
    return fail(fmt::format("`{}`, line {}, ends with `{}`, and the model goes on there", trace_path_, trace_->end_line,
                            trace_->end_text));
  }
  // The trace ends where time stands still: does the model stop at that instant, too?
  bool ends_in_time_lock() {
    while (core_.is_timed() && core_.candidate_count() == 0) {
      const rt::i64 next = core_.time().next_change();
      if (next > core_.time().wait_limit(ends_)) {
        (void)core_.time().fail_time_lock();
        return fault(nullptr);
      }
      if (next == rt::kForever) break;
      if (!core_.time().advance(next)) return fault(nullptr);
    }
    return no_such_end();
  }
  bool fail(std::string what) {
    compilation_.diags.add(Diag::kB5021, {}, std::move(what));
    return false;
  }
  // To the instant of the choice, over those at which something changes.
  bool pass_time(const TraceState& state, const std::string& instant) {
    const rt::i64 to = rt::parse_time(instant);
    if (to < 0)
      return fail(
          fmt::format("state #{} of `{}` is left at `{}`, which is no instant", state.number, trace_path_, instant));
    if (to < core_.now())
      return fail(
          fmt::format("state #{} of `{}` is left at {}, before it is reached", state.number, trace_path_, instant));
    while (core_.now() < to) {
      const rt::i64 next = std::min(to, core_.time().next_change());
      if (next > core_.time().wait_limit(ends_))
        return fail(fmt::format("state #{} of `{}` is left at {}, to which time may not pass in the model",
                                state.number, trace_path_, instant));
      if (!core_.time().advance(next)) return fault(&state);
    }
    return true;
  }
  bool differ(const TraceState& state, const std::vector<Shown>& theirs, const std::vector<Shown>& ours) {
    auto d = compilation_.diags.report(
        Diag::kB5021, {}, fmt::format("state #{} differs from `{}`, line {}", state.number, trace_path_, state.line));
    for (const std::string& text : missing_in(theirs, ours)) d.note("only in the trace: " + text);
    for (const std::string& text : missing_in(ours, theirs)) d.note("only in the model: " + text);
    d.note("the trace has" + set_text(theirs)).note("the model has" + set_text(ours));
    return false;
  }
  // Returns true if the model's error has the kind that ends the trace, and the names and the instant that the trace
  // gives. Of a cycle of priorities only the kind is compared: a message may begin with any member of the cycle.
  [[nodiscard]] bool is_named_fault() const {
    const rt::Fault& fault = core_.fault();
    if (trace_->end != end_of(fault.code)) return false;
    const rt::i64 lock = rt::parse_time(trace_->end_lock);
    if (fault.code == rt::FaultCode::TimeLock && lock >= 0 && lock != core_.now()) return false;
    if (!trace_->end_invariant.empty() && trace_->end_invariant != fault.rule) return false;
    return trace_->end_component.empty() || fault.atom == rt::kNone ||
           trace_->end_component == core_.image().atoms[fault.atom].path();
  }
  // The model has ended with an error, after the last choice of the trace (null) or before: does the trace end so, too?
  bool fault(const TraceState* before_end) {
    if (before_end == nullptr) {
      const bool is_cut = trace_->end == TraceEnd::None && trace_->ends_behind_choice;
      if (is_cut || trace_->end == TraceEnd::CutError) return has_unnamed_fault_ = true;
      if (is_named_fault()) return agree();
    }
    const std::string at = before_end != nullptr    ? fmt::format("at state #{}", before_end->number)
                           : trace_->states.empty() ? "before the first state"
                                                    : fmt::format("at state #{}", trace_->states.back().number);
    auto d = compilation_.diags.report(
        Diag::kB5021, {},
        fmt::format("a run-time error ends the model {} of `{}`: {}", at, trace_path_, core_.fault().what));
    d.note(fmt::format("after {} step{}", steps_, steps_ == 1 ? "" : "s"));
    if (!trace_->end_text.empty()) d.note(fmt::format("the trace ends with `{}`", trace_->end_text));
    return false;
  }

  Compilation& compilation_;
  const std::string& trace_path_;
  rt::Core core_;
  PublishedEvents events_;
  rt::Bip2Writer writer_;
  std::vector<rt::i64> ends_;
  std::uint64_t compared_ = 0, steps_ = 0;
  const PublishedTrace* trace_ = nullptr;
  bool ends_with_fault_ = false, has_unnamed_fault_ = false;
  bool lists_event_ports_ = false, has_unnamed_event_ = false, is_late_ = false;
  std::uint64_t without_values_ = 0;  // events of which the trace does not show all values
};

int replay_recorded(Compilation& c, const ReplayArguments& arguments, Executor& executor) {
  const std::optional<std::string> bytes = read_file(arguments.recorded_trace);
  if (!bytes) {
    c.diags.report(Diag::kB0090, {}, arguments.recorded_trace, std::strerror(errno));
    return report(c);
  }
  if (const std::string problem = rt::recorded_problem(c.lowered->image, *bytes); !problem.empty()) {
    c.diags.report(Diag::kB0090, {}, arguments.recorded_trace, problem);
    return report(c);
  }
  if (!executor.prepare(c, arguments.backend, Optimisation::Auto)) return report(c);
  rt::RunOptions options;
  options.silent = arguments.silent;
  options.format = arguments.format;
  options.resume_path = arguments.resume_path;
  const rt::Followed followed = rt::follow(c.lowered->image, *bytes, options, stdout);
  if (!followed.problem.empty()) {
    auto d = c.diags.report(Diag::kB5021, {}, followed.problem);
    if (!followed.candidates.empty()) d.note("the model has" + followed.candidates);
  } else {
    std::printf("replay: %llu step%s and the end agree\n", static_cast<unsigned long long>(followed.steps),
                followed.steps == 1 ? "" : "s");
  }
  return report(c);
}

}  // namespace

int command_replay(const ReplayArguments& arguments) {
  Compilation c(arguments.compile);
  Executor executor;
  if (!compile(c, arguments.file, Stage::Image)) return report(c);
  if (!arguments.recorded_trace.empty()) return replay_recorded(c, arguments, executor);
  if (const std::string port = system::first_event_with_object(*c.system); !port.empty()) {
    c.diags.report(Diag::kB1900, c.root_range, "a comparison of traces with events that bring C++ objects").note(port);
    return report(c);
  }
  SourceMap traces;
  const Result<FileId> file = traces.load(arguments.published_trace);
  if (!file) {
    c.diags.report(Diag::kB0090, {}, arguments.published_trace, file.error());
    return report(c);
  }
  const Result<PublishedTrace> trace = read_published_trace(traces.text(*file));
  if (!trace) {
    c.diags.report(Diag::kB5020, {}, arguments.published_trace, trace.error());
    return report(c);
  }
  if (!executor.prepare(c, arguments.backend, Optimisation::Auto)) return report(c);
  Replay replay(c, arguments.published_trace, arguments.maximal_progress);
  const bool agree = replay.follow(*trace);
  if (agree) {
    std::printf("replay: %llu states and %llu steps agree%s\n", static_cast<unsigned long long>(replay.compared()),
                static_cast<unsigned long long>(replay.steps()), replay.has_equal_end() ? ", and the end" : "");
    if (const std::string left_out = replay.not_compared(); !left_out.empty())
      std::printf("not compared: %s\n", left_out.c_str());
  }
  return report(c);
}

}  // namespace bip::driver
