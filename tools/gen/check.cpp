// One model through everything that runs in this process.
#include "tools/gen/check.hpp"

#include "compiler/emit_cpp/emit_cpp.hpp"
#include "compiler/interp/interp.hpp"
#ifdef BIP_GEN_JIT
#include "compiler/jit/jit.hpp"
#endif
#include "compiler/steps/derive_steps.hpp"
#include "compiler/system/bsys.hpp"
#include "runtime/engine/follow.hpp"
#include "runtime/trace/trace.hpp"
#include "tools/gen/compiled.hpp"
#include "tools/gen/functions.hpp"
#include "tools/gen/traced_run.hpp"

namespace bip::gen {
namespace {

std::vector<std::string> all_traces(const rt::Image& image, std::uint64_t seed, std::uint64_t steps) {
  std::vector<std::string> traces;
  for (int k = 0; k < kRunSpecs; ++k) traces.push_back(traced_run(image, run_spec(k, seed, steps)));
  return traces;
}

std::string compare_traces(const char* kind, const std::vector<std::string>& wanted, const std::vector<std::string>& got) {
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    if (wanted[k] != got[k]) return std::string(kind) + ": run " + std::to_string(k) + ", " + first_difference(wanted[k], got[k]);
  }
  return "";
}

std::string check_formatted(const Compiled& c) {
  Compiled again = compile_texts(c.formatted);
  if (!again.problem.empty()) return "fmt: its output does not compile, " + again.problem + "\n" + c.formatted.back();
  for (std::size_t k = 0; k < c.formatted.size(); ++k) {
    if (again.formatted[k] != c.formatted[k]) return "fmt: not idempotent, " + first_difference(c.formatted[k], again.formatted[k]);
  }
  System one = *c.system, two = *again.system;
  forget_places(one);
  forget_places(two);
  std::string before = system::print(one), after = system::print(two);
  return before == after ? "" : "fmt: changes the system, " + first_difference(before, after);
}

std::string check_bsys(const Compiled& c, const std::vector<std::string>& traces, std::uint64_t seed, std::uint64_t steps) {
  std::string text = system::print(*c.system);
  Compiled again = compile_bsys(text);
  if (!again.problem.empty()) return "bsys: " + again.problem;
  std::string second = system::print(*again.system);
  if (second != text) return "bsys: print(parse(t)) differs, " + first_difference(text, second);
  interp::Interpreter interpreter(*again.lowered);
  return compare_traces("bsys trace", traces, all_traces(again.lowered->image, seed, steps));
}

// Runs of the other engines, under random delays: each must be one that the core accepts, end and last state included.
std::string check_engines(const rt::Image& image, std::uint64_t seed, std::uint64_t steps) {
  for (const rt::Engine engine : {rt::Engine::Threads, rt::Engine::Batch}) {
    // One of three ways a seed: every run waits for threads some hundred times.
    for (const std::uint64_t variant : {seed % 3}) {
      rt::RunOptions options;
      options.seed = seed + variant;
      options.has_seed = true;
      options.limit = steps;
      options.policy = variant == 2 ? rt::Policy::Fair : rt::Policy::Uniform;
      options.maximal_progress = variant != 1;
      options.engine = engine;
      options.threads = 3;
      options.perturb = variant == 0 ? 0 : seed + 1;
      options.silent = true;
      options.format = rt::TraceFormat::Binary;
      const int file = memfd_create("recorded", 0);
      options.trace_path = "/proc/self/fd/" + std::to_string(file);
      char* said = nullptr;
      std::size_t said_size = 0;
      std::FILE* out = open_memstream(&said, &said_size);
      (void)rt::run(image, options, out, out);
      std::string bytes;
      char buffer[4096];
      lseek(file, 0, SEEK_SET);
      for (ssize_t n; (n = read(file, buffer, sizeof buffer)) > 0;) bytes.append(buffer, static_cast<std::size_t>(n));
      close(file);
      rt::RunOptions quiet;
      quiet.silent = true;
      const rt::Followed followed = rt::follow(image, bytes, quiet, out);
      std::fclose(out);
      const std::string text(said, said_size);
      std::free(said);
      if (!followed.problem.empty()) {
        return std::string(rt::name_of(engine)) + ": run " + std::to_string(variant) + ": " + followed.problem + "; could be taken:" + followed.candidates + "\n" + text;
      }
    }
  }
  return "";
}

}  // namespace

std::string first_difference(const std::string& a, const std::string& b) {
  std::size_t at = 0, line = 1, start = 0;
  for (; at < a.size() && at < b.size() && a[at] == b[at]; ++at) {
    if (a[at] != '\n') continue;
    ++line;
    start = at + 1;
  }
  auto line_of = [&](const std::string& s) { return s.substr(start, s.find('\n', start) - start); };
  return "first difference at line " + std::to_string(line) + ": `" + line_of(a) + "` against `" + line_of(b) + "`";
}

SupportedModel supported_model(std::uint64_t seed) {
  SupportedModel result{generate(seed), false};
  if (compile_texts(print_packages(result.model)).problem.find("[B1900]") == std::string::npos) return result;
  return {generate(seed, Features::Plain), true};
}

std::string check_model(const Description& model, std::uint64_t seed, const CheckOptions& options, OracleCounts& counts,
                        EmittedCase* emitted) {
  Compiled c = compile_texts(print_packages(model));
  if (!c.problem.empty()) return "compile " + c.problem;
  // Functions for them come with the JIT and emitted C++; the interpreter goes without.
  steps::derive_steps(*c.lowered);
  const rt::Image& image = c.lowered->image;
  std::vector<std::string> traces;
  {
    interp::Interpreter interpreter(*c.lowered);
    std::string failure = check_naive(model, image, seed, options.steps, counts);
    if (!failure.empty()) return failure;
    traces = all_traces(image, seed, options.steps);
    failure = check_bsys(c, traces, seed, options.steps);
    if (failure.empty()) failure = check_formatted(c);
    if (failure.empty()) failure = check_engines(image, seed, options.steps);
    if (!failure.empty()) return failure;
  }
#ifdef BIP_GEN_JIT
  if (options.jit) {
    for (jit::OptLevel level : {jit::OptLevel::O0, jit::OptLevel::O2}) {
      const char* kind = level == jit::OptLevel::O0 ? "interp against jit -O0" : "interp against jit -O2";
      auto code = jit::Jit::compile(*c.lowered, level);
      if (!code) return std::string(kind) + ": " + code.error();
      std::string failure = compare_traces(kind, traces, all_traces(image, seed, options.steps));
      if (failure.empty() && level == jit::OptLevel::O2) failure = check_engines(image, seed, options.steps);
      if (!failure.empty()) return failure;
    }
  }
#endif
  if (emitted != nullptr) {
    emit_cpp::Options how;
    how.namespace_name = "m" + std::to_string(seed);
    how.with_main = false;
    how.line_directives = false;
    for (const Function& f : c.system->code.functions) {
      if (has_const_variant(f.name)) how.const_names.insert(f.name);
    }
    *emitted = {seed, emit_cpp::emit(*c.lowered, how), std::move(traces)};
  }
  return "";
}

}  // namespace bip::gen
