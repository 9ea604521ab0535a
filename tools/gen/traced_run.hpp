// One run of an image with all of its output: candidates and choices in the reference engine's format, run-time errors,
// the JSON trace, how it ended. Needs the runtime only, so that emitted programs of a batch print the same text.
#pragma once
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "bip/ffi.hpp"
#include "bip/run.hpp"
#include "runtime/core/core.hpp"
#include "runtime/engine/scheduler.hpp"
#include "tools/gen/session_run.hpp"

namespace bip::gen {

struct RunSpec {
  std::uint64_t seed = 0;
  std::uint64_t steps = 0;
  rt::Policy policy = rt::Policy::Uniform;
  rt::TraceFormat format = rt::TraceFormat::Bip2;
  bool maximal_progress = true;
  bool silent = false;
  bool session = false;  // a debugging session beside the run
};
/// What every executor runs: three policies, one of them with the JSON trace, a run without a trace, and a debugging
/// session.
inline RunSpec run_spec(int number, std::uint64_t seed, std::uint64_t steps) {
  switch (number) {
    case 0: return {.seed = seed, .steps = steps, .policy = rt::Policy::Uniform, .format = rt::TraceFormat::Bip2};
    case 1: return {.seed = seed + 1, .steps = steps, .policy = rt::Policy::First, .format = rt::TraceFormat::Steps};
    case 4: return {.seed = seed + 4, .steps = steps, .silent = true};
    case 5:
      return {.seed = seed + 5,
              .steps = steps,
              .policy = seed % 3 == 0 ? rt::Policy::Fair : rt::Policy::Uniform,
              .format = rt::TraceFormat::Steps,
              .maximal_progress = seed % 4 != 0,
              .session = true};
    default: break;
  }
  return {.seed = seed + 2,
          .steps = steps,
          .policy = rt::Policy::Fair,
          .format = rt::TraceFormat::Bip2,
          .maximal_progress = number != 3};
}
inline constexpr int kRunSpecs = 6;

/// The values of all data. A string is its text: its row says only in which order strings were made. NaN has neither
/// sign nor payload: IEEE 754 leaves both open, and compilers differ.
inline std::string data_text(const rt::Image& image, const std::vector<std::uint64_t>& data) {
  std::string text;
  std::size_t at = 0;
  for (std::uint32_t a = 0; a < image.atoms.size; ++a) {
    const rt::AtomType& type = image.atom_types[image.atoms[a].type];
    for (std::uint32_t s = 0; s < type.variables.size && at < data.size(); ++s, ++at) {
      const rt::Cell cell{.bits = data[at]};
      const rt::CellType kind = type.variables[s].type;
      if (kind == rt::CellType::String) text += std::string("\"") + rt::string_of(image, cell) + "\" ";
      else if (kind == rt::CellType::Float && std::isnan(cell.f)) text += "nan ";
      else text += std::to_string(data[at]) + " ";
    }
  }
  return text;
}

/// The state and what can happen next. Steps without an observer are another way through the core, and through compiled
/// code: what they lead to is all there is to see.
inline std::string silent_run(const rt::Image& image, const RunSpec& spec) {
  std::string text;
  rt::Core core(image);
  rt::Scheduler scheduler(rt::Policy::Uniform, spec.seed);
  core.seed_draws(spec.seed);
  bool sound = core.initialize();
  if (sound) scheduler.start(core);
  // Watched ones in between: both ways keep the other's books.
  for (std::uint64_t part = 0; part < 4 && sound && core.candidate_count() != 0; ++part) {
    if (core.steps().has_steps()) {
      const std::uint64_t done = core.steps().run(
          scheduler.prng(), spec.steps, [] { return false; }, sound);
      text += std::to_string(done) + " steps\n";
    } else {
      std::uint64_t done = 0;
      for (; done < spec.steps && sound && core.candidate_count() != 0; ++done)
        sound = core.take(scheduler.choose(core));
      text += std::to_string(done - (sound ? 0 : 1)) + " steps\n";
    }
    for (int watched = 0; watched < 3 && sound && core.candidate_count() != 0; ++watched) {
      const rt::EnabledSet::Position at = scheduler.choose(core);
      text += "choice " + std::to_string(core.enabled().number(at)) + " of " + std::to_string(core.candidate_count()) +
              "\n";
      sound = core.fire(core.candidate(at));
    }
  }
  if (!sound) return text + "fault " + core.fault().what + "\n";
  const rt::State state = core.snapshot();
  for (const std::uint32_t place : state.places) text += std::to_string(place) + " ";
  text += data_text(image, state.data.rows());
  text += "\nlist";
  for (const rt::InteractionId interaction : core.enabled().list_order())
    text += " " + std::to_string(interaction.value);
  for (std::uint64_t k = 0; k < core.candidate_count() && k < 100; ++k)
    text += " " + std::to_string(core.candidate(k).interaction.value);
  // From the same state without a history: everything must follow from it.
  rt::Core fresh(image);
  fresh.seed_draws(spec.seed);
  if (!fresh.initialize() || !fresh.restore(state) || fresh.candidate_count() != core.candidate_count())
    text += "\nthe state alone says otherwise";
  return text + "\n";
}

/// A file in memory.
inline int memory_file(const std::string& text) {
  const int file = memfd_create("bip-gen", 0);
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t n = ::write(file, text.data() + done, text.size() - done);
    if (n <= 0) break;
    done += static_cast<std::size_t>(n);
  }
  return file;
}
inline std::string path_of(int file) { return "/proc/self/fd/" + std::to_string(file); }
inline std::string text_of(int file) {
  std::string text;
  char buffer[4096];
  lseek(file, 0, SEEK_SET);
  for (ssize_t n; (n = ::read(file, buffer, sizeof buffer)) > 0;) text.append(buffer, static_cast<std::size_t>(n));
  return text;
}

/// Some events for the image's ports, by the seed; empty without such ports.
inline std::string events_text(const rt::Image& image, std::uint64_t seed) {
  const rt::Core core(image);
  std::string text;
  std::uint64_t state = seed, time = 0;
  const auto draw = [&](std::uint64_t n) {
    return ((state = state * 6364136223846793005u + 1442695040888963407u) >> 33) % n;
  };
  for (int k = 0; k < 12 && !core.events().ports().empty(); ++k) {
    const rt::EventPortRow& row = core.events().ports()[draw(core.events().ports().size())];
    const rt::AtomType& type = image.atom_types[image.atoms[row.atom].type];
    time += draw(3) == 0 ? 0 : draw(9) * 500'000;
    text += "{\"time\":" + std::to_string(time) + ",\"port\":\"" + image.atoms[row.atom].path() + "." +
            type.ports[row.port].name + "\",\"values\":[";
    const rt::Span<rt::Var>& vars = image.port_types[type.ports[row.port].type].vars;
    for (std::uint32_t v = 0; v < vars.size; ++v) {
      const std::string number = std::to_string(draw(12));
      text += v == 0 ? "" : ",";
      text += vars[v].type == rt::CellType::Bool     ? (number.size() > 1 ? "true" : "false")
              : vars[v].type == rt::CellType::String ? "\"\""
                                                     : number;
    }
    text += "]}\n";
  }
  return text;
}

inline std::string traced_run(const rt::Image& image, const RunSpec& spec) {
  const bool is_timed = rt::has_time(image);
  if (spec.silent && !is_timed) return silent_run(image, spec);
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* out = open_memstream(&text, &size);
  rt::RunOptions options;
  options.seed = spec.seed;
  options.has_seed = true;
  options.limit = spec.steps;
  // A state with thousands of interactions has as many lines in the bip2 trace: a few steps of it say enough.
  rt::Core first(image, {.progress = spec.maximal_progress ? rt::MaximalProgress::On : rt::MaximalProgress::Off});
  first.seed_draws(spec.seed);
  if (first.initialize() && first.candidate_count() > 1000) options.limit = std::min<std::uint64_t>(spec.steps, 2);
  options.policy = spec.policy;
  options.format = spec.format;
  options.maximal_progress = spec.maximal_progress;
  options.asap = spec.silent;
  const int json = spec.format == rt::TraceFormat::Steps ? memory_file("") : -1;
  if (json >= 0) options.trace_path = path_of(json);
  const std::string events = is_timed ? events_text(image, spec.seed) : "";
  const int given = events.empty() ? -1 : memory_file(events);
  const int record = events.empty() || json < 0 ? -1 : memory_file("");
  if (given >= 0) options.events_path = path_of(given);
  if (record >= 0) options.record_path = path_of(record);
  rt::RunResult result = rt::run(image, options, out, out);
  std::fclose(out);
  std::string all(text, size);
  std::free(text);
  std::string trace;
  if (json >= 0) all += trace = text_of(json);
  if (record >= 0) {
    // The same run again from its record.
    const int again = memory_file("");
    rt::RunOptions replay;
    replay.replay_path = path_of(record);
    replay.trace_path = path_of(again);
    replay.silent = true;
    std::FILE* const nowhere = std::fopen("/dev/null", "w");
    (void)rt::run(image, replay, nowhere, nowhere);
    std::fclose(nowhere);
    if (text_of(again) != trace) all += "the record gives another run: " + text_of(record) + text_of(again);
    close(again);
  }
  if (spec.session) {
    const rt::SessionOptions how{
        .seed = spec.seed,
        .policy = spec.policy,
        .progress = spec.maximal_progress ? rt::MaximalProgress::On : rt::MaximalProgress::Off,
        .trusts_cpp = true,
        .snapshot_bytes = std::size_t{1} << (8 + spec.seed % 8)};  // the stride grows within few steps
    const std::string said = session_run(image, how, options.events_path, options.limit, trace);
    all = said.starts_with(kSessionDiffers) ? said : all + said;
  }
  for (const int file : {json, given, record}) {
    if (file >= 0) close(file);
  }
  return all + "end " + std::to_string(static_cast<int>(result.end)) + " steps " + std::to_string(result.steps) +
         " exit " + std::to_string(result.exit_code) + "\n";
}

}  // namespace bip::gen
