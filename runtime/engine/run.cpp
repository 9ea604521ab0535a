// `run`: checks what was asked for, opens the files, runs the loop (run_loop.hpp).
#include "bip/run.hpp"
#include "runtime/core/text.hpp"
#include "runtime/distributed/checkpoint.hpp"
#include "runtime/distributed/distribution.hpp"

#include <algorithm>
#include <vector>

#include "runtime/engine/file_conflict.hpp"
#include "runtime/engine/run_loop.hpp"

namespace bip::rt {

namespace {

// Options that the record fixes: it says how the run was started and where it ended. Returns false after a report.
bool begin_replay(const Image& image, RunOptions& options, Record& record, std::FILE* err) {
  Result<Record> read = read_record(options.replay_path);
  if (!read) {
    std::fprintf(err, "error: %s\n", printable(read.error()).c_str());
    return false;
  }
  record = std::move(*read);
  if (record.model != image.name) {
    std::fprintf(err, "error: %s: a run of `%s` was recorded, this is `%s`\n", printable(options.replay_path).c_str(),
                 printable(record.model).c_str(), image.name);
    return false;
  }
  if (!record.has_end) {
    std::fprintf(err, "warning: %s: the last line is %s: the run was cut off there\n",
                 printable(options.replay_path).c_str(), record.is_torn ? "incomplete" : "missing");
  }
  options.seed = record.seed;
  options.has_seed = true;
  options.policy = record.policy;
  options.asap = record.asap;
  options.maximal_progress = record.maximal_progress;
  options.draws_resumes = record.draws_resumes;
  options.speed = 0;
  // A replay that takes one step more than recorded differs from the record, which is reported.
  if (record.has_end) options.limit = std::min(options.limit, record.steps + 1);
  return true;
}

// Why the trace format does not fit the run; empty: it does.
std::string format_refusal(const Image& image, const RunOptions& options) {
  const TraceFormatRow& format = row_of(options.format);
  const std::string option = std::string("--trace-format=") + format.name;
  const bool is_partial = options.engine == Engine::Threads || has_nodes(options.engine);
  if (is_partial && format.engines == TracedEngines::OneByOne)
    return option + " needs the sequential engine: it lists what each state offers";
  if (!format.has_outside && options.speed > 0 && has_time(image)) return option + " does not record runs in real time";
  if (!format.has_outside && (has_event_sources(image) || !options.events_path.empty() || !options.replay_path.empty()))
    return option + " does not record events";
  if (format.needs_file && options.trace_path.empty())
    return option + " needs --trace: it is no text for standard output";
  if (options.engine != Engine::Sequential && format.engines == TracedEngines::Sequential)
    return option + " needs the sequential engine";
  return {};
}

std::string conflict_of(const RunOptions& options) {
  std::vector<NamedFile> files;
  const auto add = [&files](const char* option, const std::string& path, FileUse use) {
    if (!path.empty()) files.push_back({option, path, use});
  };
  add("--trace", options.trace_path, FileUse::Output);
  add("--record", options.record_path, FileUse::Output);
  add("--events", options.events_path, FileUse::Input);
  add("--replay", options.replay_path, FileUse::Input);
  return file_conflict(files);
}

// Why such a run cannot be, and the way out, if `what` does not name it.
struct Refusal {
  std::string what;  // empty: the run can be
  std::string help = {};
};

// Options and models with time that engines of several threads or nodes do not run.
Refusal parallel_refusal(const Image& image, const RunOptions& options) {
  const bool is_timed = has_time(image);
  if (is_timed && !has_nodes(options.engine))
    return {"an engine with several threads does not run models with time",
            "`--engine=sequential`; with `@async`, its long actions have threads of their own"};
  if (const TimeOnNodes time = time_on_nodes(image); !time.problem.empty())
    return {"several nodes do not run " + time.problem, time.help};
  if (is_timed && options.speed > 0)
    return {"several nodes do not run models in real time",
            "leave `--real-time` out for logical time, or use `--engine=sequential`"};
  if (!options.events_path.empty()) return {"--events needs the sequential engine"};
  if (is_weighted(image)) return {"weights (`@weight`) need the sequential engine"};
  if (options.interactive || options.debug) return {"--interactive and --debug need the sequential engine"};
  if (options.profile != nullptr) return {"--profile needs the sequential engine"};
  if (!options.record_path.empty() || !options.replay_path.empty())
    return {"--record and --replay need the sequential engine"};
  return {};
}

Refusal refusal(const Image& image, const RunOptions& options) {
  if (options.engine != Engine::Sequential) {
    if (Refusal parallel = parallel_refusal(image, options); !parallel.what.empty()) return parallel;
  }
  if (options.engine != Engine::Simulated && !options.network_faults.empty())
    return {"--faults needs --engine=simulated"};
  if (!options.checkpoint_path.empty() || !options.resume_path.empty()) {
    if (!has_nodes(options.engine))
      return {"--checkpoint and --resume need --engine=simulated or --engine=distributed"};
    if (const std::string object = object_without_checkpoint(image); !object.empty())
      return {"--checkpoint and --resume: the C++ object `" + object + "` cannot be saved",
              "`--engine=sequential --seed N`: the same seed repeats a run"};
  }
  if (!has_nodes(options.engine) && options.placement != nullptr)
    return {"--placement needs --engine=simulated or --engine=distributed"};
  if (options.engine == Engine::Distributed && options.fabrics == nullptr)
    return {"--engine=distributed is an engine of `bipc run`"};
  if (std::string conflict = conflict_of(options); !conflict.empty()) return {conflict};
  return {format_refusal(image, options)};
}

}  // namespace

RunResult run(const Image& image, const RunOptions& given, std::FILE* out, std::FILE* err) {
  constexpr RunResult kRefused{End::Fault, 0, 2};
  RunOptions options = given;
  Record record;
  if (!options.replay_path.empty() && !begin_replay(image, options, record, err)) return kRefused;
  if (options.explore) {
    const ExploreResult found = explore(image, options, out, err);
    return {found.complete ? End::Deadlock : End::Limit, 0, found.exit_code};
  }
  if (const Refusal why = refusal(image, options); !why.what.empty()) {
    std::fprintf(err, "error: %s\n", printable(why.what).c_str());
    if (!why.help.empty()) std::fprintf(err, "  = help: %s\n", why.help.c_str());
    return kRefused;
  }
  RunFile trace_file(options.trace_path, err), record_file(options.record_path, err);
  if (!trace_file.open() || !record_file.open()) return kRefused;
  const std::uint64_t seed = options.has_seed ? options.seed : draw_seed();
  Output output(options, seed, out, trace_file, image);
  output.begin();
  return RunLoop(image, options, record, seed, output, {out, err, trace_file, record_file}).run();
}

}  // namespace bip::rt
