// See load_moves.hpp.
#include "compiler/driver/load_moves.hpp"

#include <cerrno>
#include <cstring>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bip/assert.hpp"
#include "compiler/base/json_text.hpp"
#include "compiler/base/read_file.hpp"
#include "compiler/driver/published_trace.hpp"
#include "compiler/system/uses_time.hpp"
#include "compiler/traces/exported_lines.hpp"
#include "runtime/engine/policies.hpp"
#include "runtime/engine/replay_record.hpp"
#include "runtime/trace/trace.hpp"

namespace bip::driver {

namespace {

using MoveFinder = std::function<std::optional<rt::EnabledSet::Position>(rt::Core&)>;

bool is_unreadable(Compilation& c, const std::string& path, const std::string& why) {
  c.diags.report(Diag::kB0090, {}, path, why);
  return false;
}

bool cannot_follow(Compilation& c, const std::string& path, std::uint64_t step, const std::string& why) {
  c.diags.report(Diag::kB5021, {}, fmt::format("step {} of `{}`: {}", step, path, why));
  return false;
}

// The next line of the text, without its end.
std::string_view take_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

bool read_json_head(Compilation& c, const RunFileText& run, rt::SessionOptions& options) {
  std::string_view text = run.text;
  const nlohmann::ordered_json head = parse_json(take_line(text));
  const auto is_text = [&](const char* key) { return head.contains(key) && head[key].is_string(); };
  if (!head.is_object() || !is_text("model") || !is_text("policy") || !head.contains("seed") ||
      !head["seed"].is_number_unsigned())
    return is_unreadable(c, run.path, "its first line is no head of a trace");
  if (head["model"] != c.lowered->image.name)
    return is_unreadable(
        c, run.path,
        fmt::format("it is a run of {}, not of {}", head["model"].get<std::string>(), c.lowered->image.name));
  const rt::PolicyRow* const policy = rt::find_policy(head["policy"].get<std::string>());
  if (policy == nullptr) return is_unreadable(c, run.path, "its policy is none of this bipc's");
  options.seed = head["seed"].get<std::uint64_t>();
  options.policy = policy->policy;
  options.draws_resumes = head.contains("resumes") && head["resumes"] == "drawn";
  return true;
}

bool read_binary_head(Compilation& c, const RunFileText& run, rt::SessionOptions& options) {
  if (const std::string why = rt::recorded_problem(c.lowered->image, run.text); !why.empty())
    return is_unreadable(c, run.path, why);
  rt::RecordedReader reader;
  rt::RecordedBegin begin;
  (void)reader.open(run.text, begin);
  options.seed = begin.seed;
  const rt::PolicyRow* const policy = rt::find_policy(begin.policy);
  BIP_ASSERT(policy != nullptr, "a sound record has the policy `{}`", begin.policy);
  options.policy = policy->policy;
  options.progress = begin.maximal_progress ? rt::MaximalProgress::On : rt::MaximalProgress::Off;
  options.draws_resumes = begin.draws_resumes;
  return true;
}

// What was written for other programs becomes JSON lines.
bool read_exported(Compilation& c, RunFileText& run) {
  const traces::Instants instants =
      system::is_timed(*c.system) ? traces::Instants::OfTheModel : traces::Instants::OfNothing;
  Result<std::string> lines = traces::is_mcap(run.text) ? traces::lines_of_mcap(run.text, instants)
                                                        : traces::lines_of_perfetto(run.text, instants);
  if (!lines) return is_unreadable(c, run.path, lines.error());
  run.text = std::move(*lines);
  return true;
}

bool read_record_head(Compilation& c, RunFileText& run, rt::SessionOptions& options) {
  Result<rt::Record> record = rt::read_record(run.path);
  if (!record) return is_unreadable(c, run.path, record.error());
  run.record = std::move(*record);
  if (run.record.model != c.lowered->image.name)
    return is_unreadable(c, run.path,
                         fmt::format("it is a run of {}, not of {}", run.record.model, c.lowered->image.name));
  options.seed = run.record.seed;
  options.policy = run.record.policy;
  options.asap = run.record.asap;
  options.draws_resumes = run.record.draws_resumes;
  options.progress = run.record.maximal_progress ? rt::MaximalProgress::On : rt::MaximalProgress::Off;
  return true;
}

// -- Steps --

bool follow_step(Compilation& c, const RunFileText& run, rt::DebugSession& session, std::uint64_t step, rt::i64 instant,
                 const MoveFinder& find) {
  const rt::Halt halt = session.follow(instant, find);
  return halt != rt::Halt::Refused || cannot_follow(c, run.path, step, session.problem());
}

// By its number if the trace has it, and the names must agree; else by its names. Values are not compared.
std::optional<rt::EnabledSet::Position> find_json_candidate(rt::Core& core, const nlohmann::ordered_json& step) {
  const auto is_meant = [&](std::uint64_t k) {
    const rt::Candidate candidate = core.candidate(k);
    std::string name;
    rt::append_candidate(name, core, candidate);
    if (step["interaction"] != name) return false;
    std::vector<rt::Participant> parts;
    core.participants(candidate, parts);
    const auto ports = step.find("ports");
    if (ports == step.end() || !ports->is_array() || ports->size() != parts.size()) return false;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const rt::AtomType& type = core.tables().atom_type(parts[i].atom);
      const std::string path = core.image().atoms[parts[i].atom].path() + "." + type.ports[parts[i].port].name;
      if (!(*ports)[i].is_object()) return false;
      const auto port = (*ports)[i].find("port");
      if (port == (*ports)[i].end() || *port != path) return false;
    }
    return true;
  };
  if (const auto choice = step.find("choice"); choice != step.end() && choice->is_number_unsigned()) {
    const auto k = choice->get<std::uint64_t>();
    if (k < core.candidate_count() && is_meant(k)) return core.position(k);
    return std::nullopt;
  }
  for (std::uint64_t k = 0; k < core.candidate_count(); ++k) {
    if (is_meant(k)) return core.position(k);
  }
  return std::nullopt;
}

bool load_json(Compilation& c, const RunFileText& run, rt::DebugSession& session) {
  std::string_view text = run.text;
  (void)take_line(text);
  for (std::uint64_t number = 0; !text.empty();) {
    const nlohmann::ordered_json line = parse_json(take_line(text));
    if (line.is_object() && line.contains("end")) return true;
    const bool is_step = line.is_object() && line.contains("step") && line.contains("interaction") &&
                         line["interaction"].is_string() &&
                         (!line.contains("time") || line["time"].is_number_integer());
    if (!is_step) return cannot_follow(c, run.path, number, "this line of the trace is no step");
    const rt::i64 instant = line.contains("time") ? line["time"].get<rt::i64>() : 0;
    const auto find = [&line](rt::Core& core) { return find_json_candidate(core, line); };
    if (!follow_step(c, run, session, number++, instant, find)) return false;
  }
  return true;
}

bool load_binary(Compilation& c, const RunFileText& run, rt::DebugSession& session) {
  rt::RecordedReader reader;
  rt::RecordedBegin begin;
  (void)reader.open(run.text, begin);
  rt::EnabledSet::Position at{};
  rt::RecordedEnd end;
  for (std::uint64_t number = 0;; ++number) {
    const rt::RecordedReader::Next next = reader.next(at, end);
    if (next == rt::RecordedReader::Next::End) {
      const std::string junk = rt::junk_problem(reader);
      return junk.empty() || is_unreadable(c, run.path, junk);
    }
    if (next == rt::RecordedReader::Next::Cut) return cannot_follow(c, run.path, number, "the trace is cut off there");
    const auto find = [&at](rt::Core& core) { return core.enabled().has(at) ? std::optional(at) : std::nullopt; };
    if (!follow_step(c, run, session, number, reader.instant(), find)) return false;
  }
}

// As `bipc replay --published` finds the chosen candidate: by its printed form.
std::optional<rt::EnabledSet::Position> find_published_candidate(rt::Core& core, const TraceState& state) {
  std::string text;
  rt::Bip2Writer().state(text, core, 0);
  const Result<PublishedTrace> ours = read_published_trace(text);
  if (!ours || core.candidate_count() == 0) return std::nullopt;
  const std::vector<std::string>& candidates = (*ours).states.front().candidates;
  BIP_ASSERT(candidates.size() == core.candidate_count(), "{} lines of {} candidates", candidates.size(),
             core.candidate_count());
  std::size_t before = 0;
  std::optional<rt::EnabledSet::Position> found;
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    if (normal_candidate(candidates[k]) != normal_candidate(without_intervals(state.chosen))) continue;
    if (before++ <= state.chosen_rank) found = core.position(k);
  }
  return found;
}

bool load_published(Compilation& c, const RunFileText& run, rt::DebugSession& session) {
  const Result<PublishedTrace> trace = read_published_trace(run.text);
  if (!trace) {
    c.diags.report(Diag::kB5020, {}, run.path, trace.error());
    return false;
  }
  std::uint64_t number = 0;
  for (const TraceState& state : (*trace).states) {
    if (state.chosen.empty()) continue;
    const rt::i64 instant = state.instant.empty() ? session.core().now() : rt::parse_time(state.instant);
    if (instant < 0) return cannot_follow(c, run.path, number, fmt::format("`{}` is no instant", state.instant));
    const auto find = [&state](rt::Core& core) { return find_published_candidate(core, state); };
    if (!follow_step(c, run, session, number++, instant, find)) return false;
  }
  return true;
}

}  // namespace

std::optional<RunFileText> read_run(Compilation& c, const std::string& path, rt::SessionOptions& options) {
  const std::optional<std::string> text = read_file(path);
  if (!text) {
    (void)is_unreadable(c, path, std::strerror(errno));
    return std::nullopt;
  }
  RunFileText run{path, *text, RecordedRun::JsonTrace, {}};
  bool is_sound = false;
  if (run.text.starts_with("BIPTRC")) {
    run.kind = RecordedRun::BinaryTrace;
    is_sound = read_binary_head(c, run, options);
  } else if (run.text.starts_with(R"({"format":"bipc-events")")) {
    run.kind = RecordedRun::EventRecord;
    is_sound = read_record_head(c, run, options);
  } else if (run.text.starts_with(R"({"format":"bipc-trace")")) {
    is_sound = read_json_head(c, run, options);
  } else if (traces::is_mcap(run.text) || traces::is_perfetto(run.text)) {
    is_sound = read_exported(c, run) && read_json_head(c, run, options);
  } else if (run.text.find("[BIP ENGINE]: ") != std::string::npos) {
    run.kind = RecordedRun::PublishedTrace;
    options.draws_resumes = false;
    is_sound = true;
  } else {
    (void)is_unreadable(c, path, "it is neither a trace (JSON lines, binary, bip2, MCAP, Perfetto) nor a record");
  }
  if (is_sound && run.kind != RecordedRun::EventRecord) {
    if (const std::string port = system::first_event_port(*c.system); !port.empty()) {
      c.diags.report(Diag::kB1900, c.root_range, "a trace of a model with events, which it does not hold,")
          .note(port)
          .help("`bipc run --record` writes a run with its events");
      is_sound = false;
    }
  }
  return is_sound ? std::optional(std::move(run)) : std::nullopt;
}

bool load_moves(Compilation& c, const RunFileText& run, rt::DebugSession& session) {
  switch (run.kind) {
    case RecordedRun::JsonTrace: return load_json(c, run, session);
    case RecordedRun::BinaryTrace: return load_binary(c, run, session);
    case RecordedRun::PublishedTrace: return load_published(c, run, session);
    case RecordedRun::EventRecord: break;
  }
  if (session.follow_record(run.path, run.record) != rt::Halt::Refused) return true;
  c.diags.report(Diag::kB5021, {}, fmt::format("`{}` does not fit the model: {}", run.path, session.problem()));
  return false;
}

}  // namespace bip::driver
