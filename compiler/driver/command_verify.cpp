// `bipc verify`: invariants first; a candidate that they leave open is looked for with the engine's core.
//
// Three verdicts. Deadlock-free is a proof (invariants, or every reachable state was visited); deadlock has been replayed
// before it is told; everything else is unknown, with the reason. A run-time error ends a run and is no deadlock; if a
// search meets one it is mentioned.
#include <cstdio>

#include <nlohmann/json.hpp>

#include "compiler/driver/commands.hpp"
#include "compiler/driver/emit_stage.hpp"
#include "compiler/driver/executor.hpp"
#include "compiler/driver/exit_codes.hpp"
#include "compiler/driver/host_compiler.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/verify/certificate.hpp"
#include "compiler/verify/prove.hpp"
#include "compiler/verify/search.hpp"

namespace bip::driver {

namespace {

constexpr std::size_t kInvariantsShown = 20;
constexpr std::size_t kComponentsShown = 20;
constexpr std::size_t kStepsShown = 100;

struct Verdict {
  int exit_code = kUnknown;
  std::string name = "unknown";
  std::string text;         // what is printed
  std::string method;       // "invariants", "exhaustive"
  std::string reason;       // unknown: why
  std::string certificate;
  std::uint64_t invariants = 0, states = 0, steps = 0;
};

std::string count_of(std::size_t count, const char* what) { return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s"); }

// What C++ remembers is outside of a state: then states can't be visited and steps can't be replayed.
bool calls_cpp(const System& system) { return !system.code.functions.empty() || !system.code.extern_types.empty(); }

void tell_free(const VerifyArguments& a, const Compilation& c, const verify::Net& net, const verify::Proof& proof, Verdict& v) {
  v.exit_code = kOk;
  v.name = "deadlock-free";
  v.method = "invariants";
  v.invariants = proof.invariants.size();
  v.text = fmt::format("deadlock-free: proved with {} ({}, {})\n", count_of(proof.invariants.size(), "invariant"),
                       count_of(c.system->atoms.size(), "component"), count_of(c.system->connectors.size(), "connector"));
  if (a.why) {
    for (std::size_t k = 0; k < proof.invariants.size() && k < kInvariantsShown; ++k) {
      v.text += "  " + verify::invariant_text(net, proof.invariants[k]) + '\n';
    }
    if (proof.invariants.size() > kInvariantsShown) v.text += fmt::format("  … and {} more\n", proof.invariants.size() - kInvariantsShown);
  }
  if (!a.certificate.empty()) v.certificate = verify::certificate(net, proof, c.root_name);
}

std::string candidate_text(const verify::Net& net, const verify::Proof& proof) {
  std::string text;
  for (std::size_t k = 0; k < proof.candidate.size() && k < kComponentsShown; ++k) text += "  " + net.mode_name(proof.candidate[k]) + '\n';
  if (proof.candidate.size() > kComponentsShown) text += fmt::format("  … and {} more\n", proof.candidate.size() - kComponentsShown);
  return text;
}

void tell_unknown(const verify::Net& net, const verify::Proof& proof, const std::string& reason, Verdict& v) {
  v.reason = reason;
  v.text = fmt::format("unknown: {}\n", reason);
  if (proof.candidate.empty()) return;
  v.text += "no invariant that was found excludes this state, in which no step is sure:\n" + candidate_text(net, proof);
}

void tell_search(const VerifyArguments& a, const Compilation& c, const verify::Net& net, const verify::Proof& proof, const verify::SearchResult& found,
            Verdict& v) {
  v.states = found.states;
  const std::string fault = found.fault.empty() ? "" : fmt::format("note: a run-time error can occur: {}\n", found.fault);
  if (found.end == verify::SearchEnd::Deadlock) {
    v.exit_code = kViolated;
    v.name = "deadlock";
    v.steps = found.choices.size();
    (void)verify::tell_deadlock(c.lowered->image, found.choices, kStepsShown, v.text);
  } else if (found.end == verify::SearchEnd::Exhausted) {
    v.exit_code = kOk;
    v.name = "deadlock-free";
    v.method = "exhaustive";
    v.text = fmt::format("deadlock-free: no deadlock among all {}\n", count_of(found.states, "reachable state")) + fault;
    if (!a.certificate.empty()) v.certificate = verify::exhaustive_certificate(*c.system, c.root_name, found.states);
  } else {
    tell_unknown(net, proof, fmt::format("the search met its limit of {} after {}", found.limit, count_of(found.states, "state")), v);
    v.text += fault;
  }
}

Verdict decide(const VerifyArguments& a, Compilation& c, Executor& executor, bool& is_ready) {
  Verdict v;
  const auto seconds = std::chrono::duration<double>(static_cast<double>(std::min<std::uint64_t>(a.timeout, 100000000)));
  const verify::Clock::time_point end = verify::Clock::now() + std::chrono::duration_cast<verify::Clock::duration>(seconds);
  const verify::Net net = verify::build_net(*c.system);
  const bool can_search = !calls_cpp(*c.system);
  bool is_prepared = false;
  verify::SearchResult found;
  const auto search = [&](const std::vector<verify::u32>& candidate, bool only_walk) {
    if (!is_prepared) is_ready = executor.prepare(c, a.backend, Optimisation::Auto);
    is_prepared = true;
    const verify::SearchLimits limits{.end = end, .megabytes = static_cast<std::size_t>(a.megabytes), .only_walk = only_walk};
    if (is_ready) found = verify::search_deadlock(net, c.lowered->image, candidate, limits);
    return !is_ready || found.end == verify::SearchEnd::Deadlock;
  };
  const verify::Proof proof = verify::prove_deadlock_freedom(
      net, end, [&](const std::vector<verify::u32>& candidate) { return can_search && search(candidate, true); });
  if (proof.end == verify::ProofEnd::Free) {
    tell_free(a, c, net, proof, v);
  } else if (proof.end == verify::ProofEnd::Timeout) {
    tell_unknown(net, proof, "the time is over", v);
  } else if (proof.end == verify::ProofEnd::Stopped) {
    if (is_ready) tell_search(a, c, net, proof, found, v);
  } else if (!can_search) {
    tell_unknown(net, proof, "the model calls C++, whose state cannot be searched", v);
  } else {
    (void)search(proof.candidate, false);
    if (is_ready) tell_search(a, c, net, proof, found, v);
  }
  return v;
}

void print_json(const Verdict& v) {
  nlohmann::ordered_json json{{"format", "bipc-verdict"}, {"version", 1}, {"verdict", v.name}};
  if (!v.method.empty()) json["method"] = v.method;
  if (v.method == "invariants") json["invariants"] = v.invariants;
  if (v.states != 0) json["states"] = v.states;
  if (v.exit_code == kViolated) json["steps"] = v.steps;
  if (!v.reason.empty()) json["reason"] = v.reason;
  json["text"] = v.text;
  const std::string text = json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n';
  std::fwrite(text.data(), 1, text.size(), stdout);
}

}  // namespace

int command_verify(const VerifyArguments& arguments) {
  Compilation c(arguments.compile);
  if (arguments.compile.emit != EmitKind::None) {
    emit_stage(c, arguments.file, Optimisation::Auto);
    return report(c);
  }
  if (!compile(c, arguments.file, Stage::Image)) return report(c);
  Executor executor;
  bool is_ready = true;
  const Verdict verdict = decide(arguments, c, executor, is_ready);
  if (!verdict.certificate.empty()) {
    const Result<bool> written = write_file(arguments.certificate, verdict.certificate);
    if (!written) c.diags.report(Diag::kB5004, {}, arguments.certificate, written.error());
  }
  if (const int code = report(c); code != 0 || !is_ready) return code;
  if (arguments.json) print_json(verdict);
  else std::fwrite(verdict.text.data(), 1, verdict.text.size(), stdout);
  return verdict.exit_code;
}

}  // namespace bip::driver
