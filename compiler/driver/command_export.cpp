// `bipc export`: writes the System in the language of another tool (compiler/exchange).
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <optional>
#include <unordered_set>

#include <fmt/format.h>

#include "compiler/base/write_file.hpp"
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/emit_stage.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/driver/read_question.hpp"
#include "compiler/library/decide.hpp"
#include "compiler/library/markov_chain.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/ffi_build.hpp"
#include "compiler/pipeline/machine.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/exchange/exchange.hpp"
#include "compiler/system/system.hpp"
#include "compiler/system/uses_time.hpp"
#include "compiler/verify/net/net_dot.hpp"
#include "compiler/verify/property/property.hpp"
#include "compiler/verify/symbolic/aiger.hpp"
#include "compiler/verify/symbolic/mode_signals.hpp"
#include "compiler/verify/symbolic/property_signal.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::driver {

namespace {

const char* format_name(ExportFormat format) {
  switch (format) {
    case ExportFormat::Promela: return "Promela";
    case ExportFormat::Pnml: return "PNML";
    case ExportFormat::Aiger: return "AIGER";
    case ExportFormat::Net: return "a net";
    case ExportFormat::Prism: return "PRISM";
  }
  BIP_UNREACHABLE("format of an export");
}

constexpr const char* kNoBranchingTime = "`possibly` asks for branching time, which the format has no form for";

// The states whose reachability is asked. A property is one of those of `bipc verify`.
verify::Signal bad_states(const Compilation& c, const verify::Question& question, verify::TransitionSystem& made) {
  switch (question.what) {
    case verify::QuestionKind::DeadlockFreedom: return made.stuck;
    case verify::QuestionKind::NoErrors: return made.error;
    case verify::QuestionKind::State: return verify::broken_signal(question.property, made, c.lowered->image);
    case verify::QuestionKind::NoLocalDeadlock:
    case verify::QuestionKind::Runs:
    case verify::QuestionKind::Branching: break;
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
  if (question.what == verify::QuestionKind::Branching) return Failure{kNoBranchingTime};
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

// Of a chain; the text has a line per step.
constexpr std::uint32_t kMostStates = 100'000;

// A label for each place of each component: "coin_HEADS".
Result<std::string> prism(Compilation& c, const ExportArguments& arguments) {
  if (const std::string what = system::first_timed(*c.system); !what.empty()) return Failure{what};
  if (uses_ffi(c)) return Failure{"it calls C++"};
  Executor executor;
  if (!executor.prepare(c, Backend::Interp, Optimisation::O0)) return Failure{"its code cannot be executed"};
  std::vector<std::string> names;
  std::unordered_set<std::string> taken;
  std::vector<std::function<bool(const rt::Core&)>> conditions;
  for (std::uint32_t row = 0; row < c.system->atoms.size(); ++row) {
    const Atom& atom = c.system->atoms[AtomId(row)];
    const std::vector<std::string>& places = c.system->atom_types[atom.type].places;
    for (std::uint32_t place = 0; place < places.size(); ++place) {
      std::string name = atom.path.substr(atom.path.find('.') + 1) + "_" + places[place];
      for (char& sign : name) {
        if (std::isalnum(static_cast<unsigned char>(sign)) == 0) sign = '_';
      }
      // Two paths may differ in signs alone.
      if (!taken.insert(name).second) taken.insert(name += fmt::format("_{}", names.size()));
      names.push_back(std::move(name));
      conditions.emplace_back([row, place](const rt::Core& core) { return core.is_marked(row, place); });
    }
  }
  std::vector<library::StateSet> sets;
  const Result<library::MarkovChain> chain = library::build_chain(
      c.lowered->image, arguments.maximal_progress ? rt::MaximalProgress::On : rt::MaximalProgress::Off,
      arguments.max_size.value_or(kMostStates), conditions, sets);
  if (!chain) return Failure{chain.error()};
  return library::prism_text(*chain, c.root_name, names, sets);
}

// `always E` and `never E` as formulas, which Promela's properties are.
verify::Formula formula_of(const verify::Question& question) {
  if (question.what == verify::QuestionKind::Runs) return question.formula;
  verify::Formula made;
  made.text = question.property.text;
  made.states.push_back(question.property);
  made.nodes.push_back({.kind = verify::FormulaKind::State});
  if (question.property.is_never) made.nodes.push_back({.kind = verify::FormulaKind::Not});
  const auto last = static_cast<std::uint32_t>(made.nodes.size() - 1);
  made.nodes.push_back({.kind = verify::FormulaKind::Constant});
  made.nodes.push_back({.kind = verify::FormulaKind::Release, .a = last + 1, .b = last});
  made.root = last + 2;
  return made;
}

Result<std::string> promela(const Compilation& c, const ExportArguments& arguments, const verify::Question& question,
                            const verify::Fairness& fairness) {
  if (question.what == verify::QuestionKind::Branching) return Failure{kNoBranchingTime};
  const bool is_formula = question.what == verify::QuestionKind::State || question.what == verify::QuestionKind::Runs;
  if (!arguments.property.empty() && !is_formula) return Failure{"a property that is neither of states nor of runs"};
  const verify::Formula formula = is_formula ? formula_of(question) : verify::Formula{};
  return exchange::promela(*c.system, {.maximal_progress = arguments.maximal_progress,
                                       .root_name = c.root_name,
                                       .formula = is_formula ? &formula : nullptr,
                                       .fairness = question.fairness ? *question.fairness : fairness});
}

Result<std::string> exported(Compilation& c, const ExportArguments& arguments, const verify::Question& question,
                             const verify::Fairness& fairness) {
  exchange::Options options{.maximal_progress = arguments.maximal_progress, .root_name = c.root_name};
  if (arguments.max_size) options.max_transitions = *arguments.max_size;
  switch (arguments.format) {
    case ExportFormat::Promela: return promela(c, arguments, question, fairness);
    case ExportFormat::Pnml: return exchange::pnml(*c.system, options);
    case ExportFormat::Aiger: return aiger(c, arguments, question);
    case ExportFormat::Net: return net(c);
    case ExportFormat::Prism: return prism(c, arguments);
  }
  BIP_UNREACHABLE("format of an export");
}

}  // namespace

int command_export(const ExportArguments& arguments) {
  if (!arguments.property.empty() && arguments.format != ExportFormat::Aiger &&
      arguments.format != ExportFormat::Promela) {
    return usage_error("`--property` is for `--format=promela` and `--format=aiger`");
  }
  if (arguments.fair != "none" && (arguments.property.empty() || arguments.format != ExportFormat::Promela)) {
    return usage_error("`--fair` is for a `--property` in `--format=promela`");
  }
  Compilation c(arguments.compile);
  if (arguments.compile.emit != EmitKind::None) {
    emit_stage(c, arguments.file, Optimisation::Auto);
    return report(c);
  }
  std::string text;
  if (compile(c, arguments.file, Stage::Image) && check_outputs(c, {arguments.output})) {
    const std::optional<verify::Question> question =
        read_question(arguments.property, library::read_question(arguments.property, *c.system), *c.system);
    const std::optional<verify::Fairness> fairness = read_fairness(arguments.fair, *c.system);
    if (!question || !fairness) return kUsage;
    Result<std::string> made = exported(c, arguments, *question, *fairness);
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
