// The command line of an emitted program: run's options, nothing else. Exit codes are bipc run's: 0 ok (a deadlock is a
// normal end), 1 a run-time error, 2 usage.
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string>
#include <utility>

#include "bip/process.hpp"
#include "bip/run.hpp"
#include "runtime/core/text.hpp"
#include "runtime/engine/policies.hpp"
#include "runtime/trace/trace_formats.hpp"

namespace bip::rt {

namespace {

constexpr const char* kHelp =
    "usage: %s [options]\n"
    "runs the model %s\n\n"
    "  --seed N                    seed of the random choices (default: drawn at random and printed)\n"
    "  -l, --limit N               stop the run after N steps (default: no limit)\n"
    "  --policy P                  how the next step is chosen: %s\n"
    "  -a, --asap                  take each step at the earliest possible instant (always so with --policy first and "
    "fair)\n"
    "  --real-time                 run in real time (default: logical time, which passes without waiting)\n"
    "  --speed F                   run in real time, with F seconds of model time per second\n"
    "  --relaxed                   in real time, report a step that starts too late as a warning instead of an error\n"
    "  --real-time-priority N      in real time, run with scheduling priority N (SCHED_FIFO, 1 to 99) and locked "
    "memory; a refusal is a warning\n"
    "  --events FILE               read external events, one JSON object per line: "
    "{\"time\":\"1s500ms\",\"port\":\"a.press\",\"values\":{\"x\":1}}\n"
    "  --record FILE               write the external events that arrive, as input of --replay\n"
    "  --replay FILE               repeat the recorded run, in logical time\n"
    "  -s, --silent                print no steps, only the seed and how the run ended\n"
    "  --show-state                print the places and data of each component at the end\n"
    "  -d, --debug                 print the candidates of each state\n"
    "  --stats                     print steps, seconds, time per step and memory at the end\n"
    "  -i, --interactive           choose each step by its number, read from standard input\n"
    "  --explore                   count all reachable states (at most --limit), deadlocks and errors\n"
    "  -f, --first-enabled         same as --policy first\n"
    "  --trace FILE                write a trace of the run to FILE (default format: json)\n"
    "  --trace-format F            format of the trace: %s\n"
    "  --engine E                  engine: sequential (default), threads (for long actions) or batch (for large "
    "systems)\n"
    "  --threads N                 worker threads of --engine=threads and batch (default: one per processor)\n"
    "  --disable-maximal-progress  disable maximal progress\n"
    "  --help                      print this help\n\n"
    "example: %s --seed 42 --limit 1000 --trace run.trace\n";

bool parse_number(const char* text, std::uint64_t& value) {
  if (*text < '0' || *text > '9') return false;
  char* end = nullptr;
  errno = 0;
  value = std::strtoull(text, &end, 10);
  return *end == '\0' && errno == 0;
}

bool parse_speed(const char* text, double& value) {
  char* end = nullptr;
  value = std::strtod(text, &end);
  return *text != '\0' && *end == '\0' && value >= 1e-6 && value <= 1e6;
}

bool parse_policy(const char* text, Policy& policy) {
  const PolicyRow* const row = find_policy(text);
  if (row != nullptr) policy = row->policy;
  return row != nullptr;
}

bool parse_format(const char* text, TraceFormat& format) {
  const TraceFormatRow* const row = find_trace_format(text);
  if (row != nullptr) format = row->format;
  return row != nullptr;
}

// "uniform (default), first or fair"
template <class Row>
std::string choices_text(std::span<const Row> rows) {
  std::string text = std::string(rows[0].name) + " (default)";
  for (std::size_t k = 1; k < rows.size(); ++k) text += std::string(k + 1 < rows.size() ? ", " : " or ") + rows[k].name;
  return text;
}

// A path is no empty word.
bool parse_path(const char* text, std::string& path) {
  path = text;
  return !path.empty();
}

bool parse_engine(const char* text, Engine& engine) {
  if (std::strcmp(text, "sequential") == 0) engine = Engine::Sequential;
  else if (std::strcmp(text, "threads") == 0) engine = Engine::Threads;
  else if (std::strcmp(text, "batch") == 0) engine = Engine::Batch;
  else return false;
  return true;
}

// From 1 to the most.
template <class Number>
bool parse_small(const char* text, std::uint64_t most, Number& number) {
  std::uint64_t value = 0;
  if (!parse_number(text, value) || value < 1 || value > most) return false;
  number = static_cast<Number>(value);
  return true;
}

}  // namespace

namespace {

int run_arguments(const Image& image, int argc, char** argv) {
  RunOptions options;
  const char* program = argc > 0 ? argv[0] : "model";
  for (int i = 1; i < argc; ++i) {
    std::string name = argv[i];
    // --name value and --name=value alike.
    const char* value = nullptr;
    const std::size_t equals = name.find('=');
    const bool joined = equals != std::string::npos;
    if (joined) {
      value = argv[i] + equals + 1;
      name.resize(equals);
    }
    bool good = true;
    if (name == "--help" || name == "-h") {
      std::printf(kHelp, program, image.name, choices_text(policies()).c_str(), choices_text(trace_formats()).c_str(),
                  program);
      return 0;
    }
    // Short names, and words for what a run does anyway: the published engine's.
    static constexpr std::pair<const char*, const char*> kShort[] = {
        {"-l", "--limit"}, {"-s", "--silent"},        {"-v", "--verbose"}, {"-V", "--version"},
        {"-a", "--asap"},  {"-f", "--first-enabled"}, {"-d", "--debug"},   {"-i", "--interactive"}};
    for (const auto& [brief, whole] : kShort) {
      if (name == brief) name = whole;
    }
    if (name == "--version") {
      std::printf("model %s, compiled by bipc\n", image.name);
      return 0;
    }
    if (name == "--silent") options.silent = true;
    else if (name == "--verbose") options.silent = false;
    else if (name == "--execute") options.explore = false;
    else if (name == "--show-state") options.show_state = true;
    else if (name == "--debug") options.debug = true;
    else if (name == "--interactive") options.interactive = true;
    else if (name == "--explore") options.explore = true;
    else if (name == "--first-enabled") options.policy = Policy::First;
    else if (name == "--asap") options.asap = true;
    else if (name == "--real-time") options.speed = options.speed > 0 ? options.speed : 1;
    else if (name == "--relaxed") options.relaxed = true;
    else if (name == "--stats") options.stats = true;
    else if (name == "--disable-maximal-progress") options.maximal_progress = false;
    else if (name == "--seed" || name == "--limit" || name == "--policy" || name == "--trace" ||
             name == "--trace-format" || name == "--speed" || name == "--events" || name == "--record" ||
             name == "--replay" || name == "--engine" || name == "--threads" || name == "--real-time-priority") {
      if (!joined && i + 1 < argc) value = argv[++i];
      if (value == nullptr) good = false;
      else if (name == "--seed") good = options.has_seed = parse_number(value, options.seed);
      else if (name == "--limit") good = parse_number(value, options.limit);
      else if (name == "--policy") good = parse_policy(value, options.policy);
      else if (name == "--engine") good = parse_engine(value, options.engine);
      else if (name == "--threads") good = parse_small(value, 256, options.threads);
      else if (name == "--real-time-priority") good = parse_small(value, 99, options.real_time_priority);
      else if (name == "--speed") good = parse_speed(value, options.speed);
      else if (name == "--trace") good = parse_path(value, options.trace_path);
      else if (name == "--events") good = parse_path(value, options.events_path);
      else if (name == "--record") good = parse_path(value, options.record_path);
      else if (name == "--replay") good = parse_path(value, options.replay_path);
      else good = parse_format(value, options.format);
    } else {
      std::fprintf(stderr, "%s: unknown option `%s`, see --help\n", program, printable(argv[i]).c_str());
      return 2;
    }
    if (!good) {
      std::fprintf(stderr, "%s: bad value for `%s`, see --help\n", program, name.c_str());
      return 2;
    }
  }
  return run(image, options, stdout, stderr).exit_code;
}

// What run_process() hands on is a function without context.
const Image* image_of_program = nullptr;

}  // namespace

int run_main(const Image& image, int argc, char** argv) {
  image_of_program = &image;
  return run_process([](int count, char** words) { return run_arguments(*image_of_program, count, words); }, argc,
                     argv);
}

}  // namespace bip::rt
