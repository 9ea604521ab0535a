// bip-gen: random BIP2 models, and the differential test of the whole compiler with them.
//
//   bip-gen --seed S --print              the model of a seed
//   bip-gen --seed S --check              its checks; on failure the reduced model
//   bip-gen --check --from S --count N [--jobs J] [--emit-cpp] [--no-jit] [--steps N] [--batch N] [--out DIR]
//   bip-gen --check --engines RUNS ...    only runs of the engines with several threads, RUNS of each a system
//   bip-gen --broadcast N                 a trigger with N receivers, for tools/bench
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "tools/gen/shrink.hpp"
#include "tools/gen/workers.hpp"

namespace bip::gen {
namespace {

struct Arguments {
  bool print = false, check = false, has_seed = false;
  std::uint64_t seed = 0, from = 1, count = 1;
  int jobs = 1, broadcast = 0, shrink_budget = 1500;
  std::size_t batch = 40;
  std::string out = "gen-failures";
  CheckOptions options;
};

constexpr const char* kUsage =
    "usage: bip-gen --seed S --print\n"
    "       bip-gen --seed S --check [--emit-cpp] [--no-jit] [--steps N]\n"
    "       bip-gen --check --from S --count N [--jobs J] [--emit-cpp] [--no-jit] [--steps N] [--batch N] [--out DIR] "
    "[--engines RUNS]\n"
    "       bip-gen --broadcast N\n"
    "example: bip-gen --check --from 1 --count 500 --jobs 2 --emit-cpp\n";

bool read_arguments(int argc, char** argv, Arguments& a) {
  for (int i = 1; i < argc; ++i) {
    std::string flag = argv[i];
    auto number = [&]() { return i + 1 < argc ? std::strtoull(argv[++i], nullptr, 10) : 0; };
    if (flag == "--print") {
      a.print = true;
    } else if (flag == "--check") {
      a.check = true;
    } else if (flag == "--emit-cpp") {
      a.options.emit_cpp = true;
    } else if (flag == "--no-jit") {
      a.options.jit = false;
    } else if (flag == "--seed") {
      a.seed = number();
      a.has_seed = true;
    } else if (flag == "--from") {
      a.from = number();
    } else if (flag == "--count") {
      a.count = number();
    } else if (flag == "--steps") {
      a.options.steps = number();
    } else if (flag == "--jobs") {
      a.jobs = static_cast<int>(number());
    } else if (flag == "--engines") {
      a.options.engine_runs = number();
    } else if (flag == "--batch") {
      a.batch = number();
    } else if (flag == "--broadcast") {
      a.broadcast = static_cast<int>(number());
    } else if (flag == "--shrink-budget") {
      a.shrink_budget = static_cast<int>(number());
    } else if (flag == "--out" && i + 1 < argc) {
      a.out = argv[++i];
    } else {
      return false;
    }
  }
  return a.print ? a.has_seed : a.check || a.broadcast > 0;
}

/// What a smaller model must still show: the part before the first colon, and a diagnostic's code if there is one.
std::string kind_of(const std::string& failure) {
  std::string kind = failure.substr(0, failure.find(':'));
  std::size_t code = failure.find("[B");
  if (code != std::string::npos && kind.starts_with("compile")) kind += failure.substr(code, 7);
  return kind;
}

void report(const Failure& failure, const Arguments& a, bool shrunk) {
  std::string seed = std::to_string(failure.seed);
  const std::string engines = a.options.engine_runs == 0 ? "" : " --engines " + std::to_string(a.options.engine_runs);
  std::printf("FAILED seed %s: %s\n  reproduce: bip-gen --seed %s --check%s%s\n", seed.c_str(), failure.what.c_str(),
              seed.c_str(), a.options.emit_cpp ? " --emit-cpp" : "", engines.c_str());
  if (!shrunk) return;
  std::string kind = kind_of(failure.what);
  CheckOptions options = a.options;
  // Emitted C++ is slow to try: only if that is what fails.
  options.emit_cpp = kind.find("C++") != std::string::npos;
  options.jit = options.jit && (kind.find("jit") != std::string::npos || kind == "crash");
  int budget = options.emit_cpp ? a.shrink_budget / 15 : a.shrink_budget;
  std::string last = failure.what;
  Description small = shrink(
      supported_model(failure.seed).model,
      [&](const Description& d) {
        std::string what = check_isolated(d, failure.seed, options);
        if (what.empty() || kind_of(what) != kind) return false;
        last = what;
        return true;
      },
      budget);
  std::filesystem::create_directories(a.out);
  std::string path = a.out + "/seed" + seed + ".bip", text = print(small);
  std::ofstream(path) << "// " << seed << ": " << kind << "\n" << text;
  std::printf("  reduced (%s): %s\n%s\n", path.c_str(), last.c_str(), text.c_str());
  std::fflush(stdout);
}

int check(Arguments& a) {
  if (a.has_seed) {
    a.from = a.seed;
    a.count = 1;
  }
  char work[] = "/tmp/bip-gen-XXXXXX";
  if (mkdtemp(work) == nullptr) return 2;
  a.options.work_dir = work;
  a.options.source_dir = BIP_GEN_SOURCE_DIR;
  a.options.runtime_lib = BIP_GEN_RUNTIME_LIB;
  a.options.cxx_flags = BIP_GEN_CXX_FLAGS;
  Totals totals = check_seeds(a.from, a.count, a.jobs, a.batch, a.options);
  for (std::size_t k = 0; k < totals.failures.size(); ++k) report(totals.failures[k], a, k < 5);
  std::filesystem::remove_all(work);
  if (totals.unsupported > 0) {
    std::printf("not supported yet (B1900), checked without: %llu systems\n",
                static_cast<unsigned long long>(totals.unsupported));
  }
  if (a.options.engine_runs == 0) {
    std::printf(
        "oracle: %llu states, %llu systems too large for it; emitted C++: %llu systems; data in columns: %llu\n",
        static_cast<unsigned long long>(totals.counts.oracle.states),
        static_cast<unsigned long long>(totals.counts.oracle.too_large),
        static_cast<unsigned long long>(totals.emitted), static_cast<unsigned long long>(totals.counts.in_columns));
  }
  const EngineCounts& engines = totals.counts.engines;
  std::printf(
      "engines: %llu runs with several threads, %llu of them in parts, %llu with known conflicts, %llu with time, "
      "%llu steps\n",
      static_cast<unsigned long long>(engines.runs), static_cast<unsigned long long>(engines.in_parts),
      static_cast<unsigned long long>(engines.with_known), static_cast<unsigned long long>(engines.timed),
      static_cast<unsigned long long>(engines.steps));
  std::printf("differential: %llu systems, %zu failed\n", static_cast<unsigned long long>(totals.models),
              totals.failures.size());
  // Of so many systems some have states that the oracle visits, and some run on engines with several threads; a run
  // without is no test.
  constexpr std::uint64_t kMany = 20;
  const std::uint64_t compared = a.options.engine_runs == 0 ? totals.counts.oracle.states : engines.steps;
  if (a.count >= kMany && compared == 0) {
    std::printf("FAILED: nothing was compared\n");
    return 1;
  }
  return totals.failures.empty() && totals.models == a.count ? 0 : 1;
}

}  // namespace
}  // namespace bip::gen

int main(int argc, char** argv) {
  bip::gen::Arguments a;
  if (!bip::gen::read_arguments(argc, argv, a)) {
    std::fputs(bip::gen::kUsage, stderr);
    return 2;
  }
  if (a.broadcast > 0) std::fputs(bip::gen::broadcast_text(a.broadcast).c_str(), stdout);
  if (a.print) std::fputs(bip::gen::print(bip::gen::supported_model(a.seed).model).c_str(), stdout);
  return a.check ? bip::gen::check(a) : 0;
}
