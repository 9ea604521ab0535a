// Checks one model on every executor of this process.
#include "tools/gen/check_model.hpp"

#include "compiler/emit_cpp/emit_cpp.hpp"
#include "compiler/interp/interp.hpp"
#ifdef BIP_GEN_JIT
#include "compiler/jit/jit.hpp"
#endif
#include "compiler/steps/derive_steps.hpp"
#include "compiler/system/bsys.hpp"
#include "compiler/verify/conflicts/next_moves.hpp"
#include "tools/gen/compiled.hpp"
#include "tools/gen/engine_runs.hpp"
#include "tools/gen/ffi_prototypes.hpp"
#include "tools/gen/traced_run.hpp"

namespace bip::gen {
namespace {

constexpr double kSecondsOfConflicts = 2;

std::vector<std::string> all_traces(const rt::Image& image, std::uint64_t seed, std::uint64_t steps) {
  std::vector<std::string> traces;
  for (int k = 0; k < kRunSpecs; ++k) traces.push_back(traced_run(image, run_spec(k, seed, steps)));
  return traces;
}

std::string compare_traces(const char* kind, const std::vector<std::string>& wanted,
                           const std::vector<std::string>& got) {
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    if (wanted[k] != got[k])
      return std::string(kind) + ": run " + std::to_string(k) + ", " + first_difference(wanted[k], got[k]);
  }
  return "";
}

std::string check_formatted(const Compiled& c) {
  Compiled again = compile_texts(c.formatted);
  if (!again.problem.empty()) return "fmt: its output does not compile, " + again.problem + "\n" + c.formatted.back();
  for (std::size_t k = 0; k < c.formatted.size(); ++k) {
    if (again.formatted[k] != c.formatted[k])
      return "fmt: not idempotent, " + first_difference(c.formatted[k], again.formatted[k]);
  }
  System first = *c.system, second = *again.system;
  forget_places(first);
  forget_places(second);
  std::string before = system::print(first), after = system::print(second);
  return before == after ? "" : "fmt: changes the system, " + first_difference(before, after);
}

std::string check_bsys(const Compiled& c, const std::vector<std::string>& traces, std::uint64_t seed,
                       std::uint64_t steps) {
  std::string text = system::print(*c.system);
  Compiled again = compile_bsys(text);
  if (!again.problem.empty()) return "bsys: " + again.problem;
  std::string second = system::print(*again.system);
  if (second != text) return "bsys: print(parse(t)) differs, " + first_difference(text, second);
  interp::Interpreter interpreter(*again.lowered);
  return compare_traces("bsys trace", traces, all_traces(again.lowered->image, seed, steps));
}

// Nothing but them: by the interpreter, which has no compiled steps, and by the JIT, which has.
std::string check_engines(const System& system, lower::LoweredSystem& lowered, std::uint64_t seed,
                          const CheckOptions& options, EngineCounts& counts) {
  const std::vector<rt::NextMove> known =
      rt::has_time(lowered.image) ? std::vector<rt::NextMove>()
                                  : verify::find_next_moves(system, verify::within_seconds(kSecondsOfConflicts)).moves;
  {
    interp::Interpreter interpreter(lowered);
    std::string failure = engine_runs(lowered.image, seed, options.engine_runs, options.steps, counts, known);
    if (!failure.empty()) return failure;
  }
#ifdef BIP_GEN_JIT
  if (options.jit) {
    auto code = jit::Jit::compile(lowered, jit::OptLevel::O2);
    if (!code) return "jit -O2: " + code.error();
    return engine_runs(lowered.image, seed, options.engine_runs, options.steps, counts, known);
  }
#endif
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
  SupportedModel result{generate(seed, Features::Drawn), false};
  if (compile_texts(print_packages(result.model)).problem.find("[B1900]") == std::string::npos) return result;
  return {generate(seed, Features::Plain), true};
}

std::string check_model(const Description& model, std::uint64_t seed, const CheckOptions& options, Counts& counts,
                        EmittedCase* emitted) {
  Compiled c = compile_texts(print_packages(model));
  if (!c.problem.empty()) return "compile " + c.problem;
  // Functions for them come with the JIT and emitted C++; the interpreter goes without.
  steps::derive_steps(*c.lowered, seed % 4 != 0 ? steps::Columns::WherePossible : steps::Columns::WhereOfUse);
  counts.in_columns += c.lowered->steps.cells.count != 0 ? 1 : 0;
  const rt::Image& image = c.lowered->image;
  std::vector<std::string> traces;
  if (options.engine_runs != 0) {
    std::string failure = check_engines(*c.system, *c.lowered, seed, options, counts.engines);
    if (!failure.empty()) return failure;
  } else {
    interp::Interpreter interpreter(*c.lowered);
    std::string failure = check_naive(model, image, seed, options.steps, counts.oracle);
    if (!failure.empty()) return failure;
    traces = all_traces(image, seed, options.steps);
    for (const std::string& trace : traces) {
      if (trace.starts_with(kSessionDiffers)) return trace;
    }
    failure = check_bsys(c, traces, seed, options.steps);
    if (failure.empty()) failure = check_formatted(c);
    if (failure.empty()) failure = engine_runs(image, seed, 1, options.steps, counts.engines);
    if (!failure.empty()) return failure;
  }
#ifdef BIP_GEN_JIT
  if (options.jit && options.engine_runs == 0) {
    for (jit::OptLevel level : {jit::OptLevel::O0, jit::OptLevel::O2}) {
      const char* kind = level == jit::OptLevel::O0 ? "interp against jit -O0" : "interp against jit -O2";
      auto code = jit::Jit::compile(*c.lowered, level);
      if (!code) return std::string(kind) + ": " + code.error();
      std::string failure = compare_traces(kind, traces, all_traces(image, seed, options.steps));
      if (failure.empty() && level == jit::OptLevel::O2)
        failure = engine_runs(image, seed, 1, options.steps, counts.engines);
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
