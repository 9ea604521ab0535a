// `bipc export`: writes the System in the language of another tool (compiler/exchange).
#include <algorithm>
#include <cstdio>
#include <optional>

#include <fmt/format.h>

#include "compiler/base/write_file.hpp"
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/emit_stage.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/driver/read_question.hpp"
#include "compiler/library/decide.hpp"
#include "compiler/pipeline/machine.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/exchange/exchange.hpp"
#include "compiler/system/uses_time.hpp"
#include "compiler/verify/net/net_dot.hpp"
#include "compiler/verify/property/property.hpp"
#include "compiler/verify/symbolic/aiger.hpp"
#include "compiler/verify/symbolic/mode_signals.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::driver {

namespace {

const char* format_name(ExportFormat format) {
  switch (format) {
    case ExportFormat::Promela: return "Promela";
    case ExportFormat::Pnml: return "PNML";
    case ExportFormat::Aiger: return "AIGER";
    case ExportFormat::Net: return "a net";
  }
  BIP_UNREACHABLE("format of an export");
}

// The states whose reachability is asked. A property is one of those of `bipc verify`.
verify::Signal bad_states(const Compilation& c, const verify::Question& question, verify::TransitionSystem& made) {
  switch (question.what) {
    case verify::QuestionKind::DeadlockFreedom: return made.stuck;
    case verify::QuestionKind::NoErrors: return made.error;
    case verify::QuestionKind::State: return verify::broken_signal(question.property, made, c.lowered->image);
    case verify::QuestionKind::NoLocalDeadlock:
    case verify::QuestionKind::Runs: break;
  }
  BIP_UNREACHABLE("a question that no property asks");
}

// "a float (tank.bip:11)"
std::string imprecision(const verify::Imprecision& first, const System& system) {
  if (first.loc.line == 0 || first.loc.file >= system.files.size()) return first.what;
  return fmt::format("{} ({}:{})", first.what, system.files[first.loc.file], first.loc.line);
}

// What the transition system follows only approximately is refused: another tool's answer must hold of the model.
Result<std::string> aiger(const Compilation& c, const ExportArguments& arguments, const verify::Question& question) {
  if (const std::string what = system::first_timed(*c.system); !what.empty()) return Failure{what};
  if (question.what == verify::QuestionKind::Runs)
    return Failure{"a property of runs is no set of states, which the output of a circuit asks for"};
  if (!arguments.maximal_progress) return Failure{"the transition system has maximal progress"};
  const auto is_float = [](const verify::PropertyNode& node) { return node.type == Type::Float; };
  if (std::any_of(question.property.nodes.begin(), question.property.nodes.end(), is_float))
    return Failure{"the property has a float"};
  verify::TransitionSystem made =
      verify::build_transition_system(*c.system, c.lowered->image, available_memory() / 2000000);
  if (!made.unsupported.empty()) return Failure{made.unsupported};
  if (made.starts_with_fault) return Failure{"the initial state is a run-time error"};
  if (!verify::ranges_hold(made, {})) return Failure{"the ranges of its data could not be confirmed"};
  const verify::Signal bad = made.aig.make_or(bad_states(c, question, made), made.lost);
  if (!made.imprecisions.empty()) return Failure{"it depends on " + imprecision(*made.imprecisions.begin(), *c.system)};
  return verify::aiger_text(made, bad, *c.system);
}

Result<std::string> net(const Compilation& c) {
  const verify::Net made = verify::build_net(*c.system);
  if (made.too_large_atom != verify::kNoRow) return Failure{"a component has too many local states"};
  return verify::net_dot(made);
}

Result<std::string> exported(const Compilation& c, const ExportArguments& arguments, const verify::Question& question) {
  const exchange::Options options{.maximal_progress = arguments.maximal_progress, .root_name = c.root_name};
  switch (arguments.format) {
    case ExportFormat::Promela: return exchange::promela(*c.system, options);
    case ExportFormat::Pnml: return exchange::pnml(*c.system, options);
    case ExportFormat::Aiger: return aiger(c, arguments, question);
    case ExportFormat::Net: return net(c);
  }
  BIP_UNREACHABLE("format of an export");
}

}  // namespace

int command_export(const ExportArguments& arguments) {
  if (!arguments.property.empty() && arguments.format != ExportFormat::Aiger) {
    std::fputs("bipc export: `--property` is for `--format=aiger`\n", stderr);
    return kUsage;
  }
  Compilation c(arguments.compile);
  if (arguments.compile.emit != EmitKind::None) {
    emit_stage(c, arguments.file, Optimisation::Auto);
    return report(c);
  }
  std::string text;
  if (compile(c, arguments.file, Stage::Image) && check_outputs(c, {arguments.output})) {
    const std::optional<verify::Question> question =
        read_question("export", arguments.property, library::read_question(arguments.property, *c.system), *c.system);
    if (!question) return kUsage;
    Result<std::string> made = exported(c, arguments, *question);
    if (!made) {
      c.diags.report(Diag::kB5060, {}, format_name(arguments.format), made.error());
    } else if (arguments.output.empty()) {
      text = std::move(*made);
    } else if (const auto written = write_file(arguments.output, *made); !written) {
      c.diags.report(Diag::kB5004, {}, arguments.output, written.error());
    }
  }
  const int code = report(c);
  if (code == 0) std::fwrite(text.data(), 1, text.size(), stdout);
  return code;
}

}  // namespace bip::driver
