// Runs of the engines with several threads under random delays, and of the simulated one with whatever can go wrong in
// a network. The core must accept each of them, including its end and its last state
// (runtime/engine/replay_record.hpp). Needs the runtime only, so that emitted programs of a batch execute the same
// runs.
#pragma once
#include <sys/mman.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <string>
#include <vector>

#include "bip/run.hpp"
#include "runtime/core/programs/batch_plan.hpp"
#include "runtime/core/core.hpp"
#include "runtime/distributed/distribution.hpp"
#include "runtime/engine/replay_record.hpp"
#include "runtime/trace/trace.hpp"

namespace bip::gen {

struct EngineCounts {
  std::uint64_t runs = 0, steps = 0;
  std::uint64_t in_parts = 0;    // of them, runs of the batch engine whose system came apart
  std::uint64_t with_known = 0;  // and simulated ones that know more of conflicts than places tell
  std::uint64_t timed = 0;       // and simulated ones of models with time
  void add(const EngineCounts& more) {
    runs += more.runs;
    steps += more.steps;
    in_parts += more.in_parts;
    with_known += more.with_known;
    timed += more.timed;
  }
};

/// Does the batch engine do more than the sequential one here?
inline bool comes_apart(const rt::Image& image) {
  rt::Core core(image);
  core.keep_list();
  return core.steps().can_batch() && rt::plan_batch(core.tables(), core.priorities(), 3, true).parts > 1;
}

/// One run, recorded and followed. Empty: accepted.
inline std::string engine_run(const rt::Image& image, rt::RunOptions options, EngineCounts& counts) {
  options.has_seed = true;
  options.silent = true;
  options.format = rt::TraceFormat::Binary;
  const int file = memfd_create("recorded", 0);
  options.trace_path = "/proc/self/fd/" + std::to_string(file);
  char* said = nullptr;
  std::size_t said_size = 0;
  std::FILE* out = open_memstream(&said, &said_size);
  counts.steps += rt::run(image, options, out, out).steps;
  ++counts.runs;
  std::string bytes;
  char buffer[4096];
  lseek(file, 0, SEEK_SET);
  for (ssize_t n; (n = ::read(file, buffer, sizeof buffer)) > 0;) bytes.append(buffer, static_cast<std::size_t>(n));
  close(file);
  rt::RunOptions quiet;
  quiet.silent = true;
  const rt::Followed followed = rt::follow(image, bytes, quiet, out);
  std::fclose(out);
  const std::string text(said, said_size);
  std::free(said);
  if (followed.problem.empty()) return "";
  // A lost node may have taken a step's error with it: the step never ended.
  const bool has_crash = options.network_faults.find("crash") != std::string::npos;
  if (has_crash && followed.problem.find("run-time error ends the model") != std::string::npos) return "";
  return std::string(rt::name_of(options.engine)) + ": seed " + std::to_string(options.seed) +
         (options.maximal_progress ? "" : ", all interactions") +
         (options.network_faults.empty() ? "" : ", faults " + options.network_faults) + ": " + followed.problem +
         "; could be taken:" + followed.candidates + "\n" + text;
}

/// What goes wrong in simulated runs, in turn.
inline constexpr const char* kNetworkFaults[] = {"", "lose 10%, double 10%", "cut 1-2 3ms..60ms, slow 2 x10",
                                                 "crash 2 5ms", "cut 1-2 1ms..200ms, lose 30%, crash 1 20ms"};

/// `runs` runs of each engine: policies, maximal progress, delays and faults of the network in turn. `known`: what the
/// prover knows of conflicts, for the simulated ones.
inline std::string engine_runs(const rt::Image& image, std::uint64_t seed, std::uint64_t runs, std::uint64_t steps,
                               EngineCounts& counts, const std::vector<rt::NextMove>& known = {}) {
  // Models with time run on nodes only, and not all of them.
  const bool is_timed = rt::has_time(image);
  if (is_timed && !rt::time_on_nodes(image).problem.empty()) return "";
  const bool has_parts = comes_apart(image);
  for (std::uint64_t k = 0; k < runs; ++k) {
    rt::RunOptions options;
    options.seed = seed + k;
    options.limit = steps;
    // One of three ways a seed: every run waits for threads some hundred times.
    const std::uint64_t variant = options.seed % 3;
    options.policy = variant == 2 ? rt::Policy::Fair : rt::Policy::Uniform;
    options.maximal_progress = variant != 1;
    options.threads = 2 + static_cast<std::uint32_t>(k % 3);
    options.perturb = variant == 0 ? 0 : options.seed + 1;
    options.engine = rt::Engine::Threads;
    options.asap = is_timed && variant == 0 && seed % 2 == 0;
    if (is_timed) ++counts.timed;
    else if (std::string problem = engine_run(image, options, counts); !problem.empty()) return problem;
    options.engine = rt::Engine::Simulated;
    options.nodes = 2 + static_cast<std::uint32_t>(options.seed % 4);
    options.network_faults = kNetworkFaults[options.seed % std::size(kNetworkFaults)];
    options.on_loss = options.seed % 2 == 0 ? rt::OnLoss::Stop : rt::OnLoss::GoOn;
    const rt::Tables tables = rt::link(image, rt::MaximalProgress::On);
    rt::Placement placement = rt::place_atoms(tables, rt::link_priorities(tables), options.nodes);
    options.placement = &placement;
    if (!known.empty()) {
      placement.next_moves = known;
      ++counts.with_known;
    }
    if (std::string problem = engine_run(image, options, counts); !problem.empty()) return problem;
    // The same with several coordinators for each conflict set, and locks.
    placement.split_above = 1;
    if (is_timed) continue;
    if (std::string problem = engine_run(image, options, counts); !problem.empty()) return problem;
    options.placement = nullptr;
    options.network_faults.clear();
    options.engine = rt::Engine::Batch;
    // Only these take epochs.
    options.policy = rt::Policy::Uniform;
    options.maximal_progress = true;
    options.perturb = options.seed + 1;
    if (has_parts) ++counts.in_parts;
    else if (k != 0) continue;  // a sequential run once more
    if (std::string problem = engine_run(image, options, counts); !problem.empty()) return problem;
  }
  return "";
}

}  // namespace bip::gen
