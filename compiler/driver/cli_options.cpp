// One function per command: its description, its options, its example.
#include "compiler/driver/cli_options.hpp"

#include <map>

#include "compiler/base/log.hpp"
#include "runtime/distributed/distribution.hpp"
#include "runtime/engine/event_file.hpp"
#include "runtime/engine/policies.hpp"
#include "runtime/trace/trace_formats.hpp"

namespace bip::driver {

std::string not_one_of(const std::string& text, const std::string& shown) {
  return fmt::format("`{}` is not one of {}", text, shown);
}

namespace {

template <class T>
using Names = std::map<std::string, T>;

const Names<DiagnosticFormat> kFormats{{"frame", DiagnosticFormat::Frame},
                                       {"short", DiagnosticFormat::Short},
                                       {"json", DiagnosticFormat::Json},
                                       {"sarif", DiagnosticFormat::Sarif}};
const Names<ColorChoice> kColors{
    {"auto", ColorChoice::Auto}, {"always", ColorChoice::Always}, {"never", ColorChoice::Never}};
const Names<EmitKind> kEmits{{"tokens", EmitKind::Tokens}, {"syntax", EmitKind::Syntax}, {"model", EmitKind::Model},
                             {"system", EmitKind::System}, {"llvm", EmitKind::Llvm},     {"asm", EmitKind::Asm},
                             {"cpp", EmitKind::Cpp},       {"dot", EmitKind::Dot},       {"json", EmitKind::Json}};
const Names<PrintAfter> kPrintAfter{
    {"parse", PrintAfter::Parse}, {"build-model", PrintAfter::BuildModel}, {"instantiate", PrintAfter::Instantiate}};
const Names<GraphFormat> kGraphFormats{
    {"dot", GraphFormat::Dot}, {"json", GraphFormat::Json}, {"svg", GraphFormat::Svg}, {"png", GraphFormat::Png}};
const Names<graph::Show> kShows{
    {"all", graph::Show::All}, {"structure", graph::Show::Structure}, {"automata", graph::Show::Automata}};
const Names<Shell> kShells{{"bash", Shell::Bash}, {"zsh", Shell::Zsh}, {"fish", Shell::Fish}};
const Names<Backend> kBackends{{"jit", Backend::Jit}, {"interp", Backend::Interp}};

// The policies and trace formats of the runtime's tables: which are choices of an option, and how the help shows them.
struct PolicyChoices {
  PolicyChoices() {
    for (const rt::PolicyRow& row : rt::policies()) {
      names.emplace(row.name, row.policy);
      shown += shown.empty() ? row.name : std::string("|") + row.name;
    }
  }
  Names<rt::Policy> names;
  std::string shown;
};
struct FormatChoices {
  explicit FormatChoices(bool (*has)(const rt::TraceFormatRow&)) {
    for (const rt::TraceFormatRow& row : rt::trace_formats()) {
      if (!has(row)) continue;
      names.emplace(row.name, row.format);
      shown += shown.empty() ? row.name : std::string("|") + row.name;
      if (*row.help != '\0') help += fmt::format("{} {} {}", help.empty() ? ":" : ",", row.name, row.help);
    }
  }
  Names<rt::TraceFormat> names;
  std::string shown;
  std::string help;  // ": bip2 is …, binary is …"
};
const PolicyChoices kPolicies;
const FormatChoices kRunFormats([](const rt::TraceFormatRow&) { return true; });
const FormatChoices kTextFormats([](const rt::TraceFormatRow& row) { return row.is_text; });
const FormatChoices kServedFormats([](const rt::TraceFormatRow& row) { return row.can_embed; });
const Names<rt::Engine> kEngines{{"sequential", rt::Engine::Sequential},
                                 {"threads", rt::Engine::Threads},
                                 {"batch", rt::Engine::Batch},
                                 {"simulated", rt::Engine::Simulated}};
const Names<rt::OnLoss> kOnLoss{{"stop", rt::OnLoss::Stop}, {"go-on", rt::OnLoss::GoOn}};

const Names<ExportFormat> kExportFormats{{"promela", ExportFormat::Promela},
                                         {"pnml", ExportFormat::Pnml},
                                         {"aiger", ExportFormat::Aiger},
                                         {"net", ExportFormat::Net}};
const Names<rt::StateReduction> kReductions{
    {"none", rt::StateReduction::None}, {"por", rt::StateReduction::Por}, {"symmetry", rt::StateReduction::Symmetry}};

// CLI11 alone would take "5x" and "-1" for a number, or call them inconvertible.
CLI::Validator is_number() {
  return CLI::Validator(
      [](std::string& text) {
        const bool digits = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
        // 19 digits always fit 64 bits; 20 need a look.
        const bool fits = text.size() < 20 || (text.size() == 20 && text <= "18446744073709551615");
        return digits && fits ? std::string() : fmt::format("`{}` is not a whole number from 0 to 2^64 - 1", text);
      },
      "");
}

// Identifiers with `::` between them.
bool is_namespace(const std::string& text) {
  bool begins = true;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
    if (c == ':' && !begins && text.compare(i, 2, "::") == 0) {
      ++i;
      begins = true;
    } else if (is_letter || (!begins && c >= '0' && c <= '9')) {
      begins = false;
    } else {
      return false;
    }
  }
  return !begins;
}

// CLI11's ranges let NaN pass.
CLI::Validator is_speed() {
  return CLI::Validator(
      [](std::string& text) {
        double speed = 0;
        const bool is_good = CLI::detail::lexical_cast(text, speed) && speed >= 1e-6 && speed <= 1e6;
        return is_good ? std::string() : fmt::format("`{}` is not a number from 0.000001 to 1000000", text);
      },
      "");
}

CLI::Option* add_duration(CLI::App& command, const char* name, std::int64_t& ns, const char* help) {
  return command
      .add_option_function<std::string>(
          name, [&ns](const std::string& text) { ns = rt::parse_time(text); }, help)
      ->check(CLI::Validator(
          [](std::string& text) {
            return rt::parse_time(text) < 0 ? fmt::format("`{}` is no duration such as 1s500ms", text) : std::string();
          },
          ""))
      ->type_name("TIME");
}

// ---- machine code and who runs it: how it is made, kept and watched, and its priority

void add_cache_options(CLI::App& command, CacheOptions& cache) {
  CLI::Option* off = command.add_flag("--no-cache", cache.is_off, "neither read nor write the cache");
  command
      .add_option("--cache", cache.folder, "folder of the cache (default: $XDG_CACHE_HOME/bipc, else ~/.cache/bipc)")
      ->type_name("DIR")
      ->excludes(off);
  command
      .add_option("--cache-size", cache.megabytes,
                  "size limit of the cache; the least recently used entries are removed (default: 256)")
      ->check(CLI::Range(1, 1 << 20))
      ->type_name("MB");
}

// Of commands that compile and load what a model brings.
void add_no_cpp(CLI::App& command, CompileOptions& options) {
  command.add_flag("--no-cpp", options.refuses_cpp,
                   "refuse models that call C++: nothing that a model brings is compiled or loaded");
}

// -O; -O1 is for the C++ compiler only.
enum class CompilerLevels : std::uint8_t { O0O2, O0O1O2 };
void add_optimisation(CLI::App& app, Optimisation& level, CompilerLevels levels, const std::string& help) {
  const bool with_o1 = levels == CompilerLevels::O0O1O2;
  const std::string shown = with_o1 ? "0|1|2" : "0|2";
  app.add_option_function<std::string>(
         "-O",
         [&level](const std::string& text) {
           level = text == "0" ? Optimisation::O0 : text == "1" ? Optimisation::O1 : Optimisation::O2;
         },
         help)
      ->check(CLI::Validator(
          [shown, with_o1](std::string& text) {
            return text == "0" || text == "2" || (with_o1 && text == "1")
                       ? ""
                       : fmt::format("`{}` is not one of {}", text, shown);
          },
          ""))
      ->type_name(shown);
}

// Of `run`: options about the code that it makes and how it is watched. After --explore.
void add_code_options(CLI::App& command, RunArguments& a) {
  command
      .add_flag(
          "-g", a.for_debuggers,
          "generate debug information that maps machine code to lines of the model, for gdb and perf (--backend=jit)")
      ->excludes("--explore");
  CLI::Option* explores = command.get_option("--explore");
  command.add_flag("--profile", a.profile, "print a profile at the end: time per interaction, type, guard and action")
      ->excludes(explores);
  command.add_option("--profile-json", a.profile_path, "write the profile as JSON to PATH")
      ->type_name("PATH")
      ->excludes(explores);
}

void add_real_time_priority(CLI::App& command, int& priority) {
  command
      .add_option("--real-time-priority", priority,
                  "in real time, run with scheduling priority N (SCHED_FIFO, 1 to 99) and locked memory; a refusal is "
                  "a warning")
      ->check(CLI::Range(1, 99))
      ->type_name("N");
}

// An option with a closed set of values; `shown` is how the help writes them.
template <class T>
void add_choice(CLI::App& app, const std::string& name, T& value, const Names<T>& names, const std::string& shown,
                const std::string& help, const std::string& group = "Options") {
  app.add_option_function<std::string>(
         name, [&value, &names](const std::string& text) { value = names.at(text); }, help)
      ->check(CLI::Validator(
          [&names, shown](std::string& text) { return names.contains(text) ? "" : not_one_of(text, shown); }, ""))
      ->type_name(shown)
      ->group(group);
}

void add_color(CLI::App& app, ColorChoice& color) {
  add_choice(app, "--color", color, kColors, "auto|always|never",
             "coloured diagnostics (default: auto, which means on a terminal unless NO_COLOR is set)");
}

}  // namespace

void add_diagnostics(CLI::App& app, CompileOptions& options) {
  add_choice(app, "--diagnostics", options.render.format, kFormats, "frame|short|json|sarif",
             "format of errors and warnings (default: frame)");
  add_color(app, options.color);
  app.add_flag("--Werror", options.fatal_warnings,
               "treat all warnings as errors; --Werror=CODE treats warnings of one code as errors and may be repeated")
      ->check(CLI::Validator(
          [](std::string& text) {
            const std::optional<Diag> kind = find_diag(text);
            if (text == "true" || (kind && info(*kind).severity == Severity::Warning)) return std::string();
            return fmt::format("`{}` is not the code of a warning", text);
          },
          ""));
  app.add_flag("--explain", options.explain,
               "print the explain page of the first error, or of the first warning if there is no error");
}

namespace {

void add_folders(CLI::App& app, CompileOptions& options) {
  app.add_option("-I", options.folders,
                 "search DIR for packages, before the folder of the file and the standard library; may be repeated")
      ->allow_extra_args(false)
      ->type_name("DIR");
}

void add_compile(CLI::App& app, CompileOptions& options) {
  add_folders(app, options);
  app.add_option(
         "--root", options.root,
         "root component, for example 'Ring(10)' (default: the only parameterless compound that nothing instantiates)")
      ->type_name("TYPE(ARGS)");
  app.add_option(
         "--max-instances", options.max_instances,
         "refuse a system of more than N atoms, or as many compounds, connectors or priorities (default: 2000000)")
      ->check(is_number())
      ->type_name("N");
  add_choice(app, "--emit", options.emit, kEmits, "tokens|syntax|model|system|llvm|asm|cpp|dot|json",
             "print the product of this stage of the compiler and stop");
  add_choice(app, "--print-after", options.print_after, kPrintAfter, "parse|build-model|instantiate",
             "print the product of this pass to standard error and go on");
  app.add_flag("--time-passes", options.time_passes, "print the duration of each pass to standard error");
  app.add_flag("--verify-each", options.verify_each,
               "check the invariants of the compiler's data structures after each pass");
  add_diagnostics(app, options);
}

void add_check(CLI::App& app, CheckArguments& a) {
  CLI::App* command = app.add_subcommand("check", "report all errors and warnings of models without running them");
  command->add_option("FILE", a.files, "model files (.bip or .bsys)")->required()->type_name("");
  command
      ->add_option("--placement", a.placement_path,
                   "print what a run distributed by this file (see distributed.md) would be: interactions over several "
                   "nodes, conflict sets, messages")
      ->type_name("PATH");
  command
      ->add_option(
          "--lesson", a.lesson,
          "judge FILE as the solution of the exercises of lesson N of the book, or of exercise K alone; exit code 3 "
          "if one is not solved")
      ->type_name("N[.K]");
  add_compile(*command, a.compile);
  command->footer("Example:\n  bipc check --diagnostics=short model.bip\n  bipc check --lesson 1 kitchen.bip");
}

// A seed without which one is drawn.
void add_seed(CLI::App& command, std::uint64_t& seed, bool& is_given, const std::string& help) {
  command
      .add_option_function<std::uint64_t>(
          "--seed",
          [&seed, &is_given](const std::uint64_t& value) {
            seed = value;
            is_given = true;
          },
          help)
      ->check(is_number())
      ->type_name("N");
}

void add_run(CLI::App& app, RunArguments& a) {
  CLI::App* command = app.add_subcommand("run", "run a model and print its steps");
  command
      ->add_option(
          "FILE", a.file,
          "model file (.bip or .bsys), or a folder with a program `run`, which is started with --seed and --speed")
      ->required()
      ->type_name("");
  add_seed(*command, a.run.seed, a.run.has_seed, "seed of the random choices (default: drawn at random and printed)");
  command->add_option("-l,--limit", a.run.limit, "stop the run after N steps (default: no limit)")
      ->check(is_number())
      ->type_name("N");
  add_choice(*command, "--policy", a.run.policy, kPolicies.names, kPolicies.shown,
             "how the next step is chosen among the candidates (default: uniform)");
  add_choice(*command, "--backend", a.backend, kBackends, "jit|interp",
             "executor of guards, actions and transfers (default: jit if it is built in)");
  add_cache_options(*command, a.compile.cache);
  add_no_cpp(*command, a.compile);
  add_optimisation(*command, a.optimisation, CompilerLevels::O0O2,
                   "compile with this optimisation level before the first step (default: begin interpreted and change "
                   "to -O2 code during the run)");
  command->add_option("--trace", a.run.trace_path, "write a trace of the run to PATH (default format: json)")
      ->type_name("PATH");
  add_choice(*command, "--trace-format", a.run.format, kRunFormats.names, kRunFormats.shown,
             "format of the trace" + kRunFormats.help + " (default: steps, or json with --trace)");
  add_choice(*command, "--engine", a.run.engine, kEngines, "sequential|threads|batch|simulated",
             "threads executes long actions in parallel; batch executes independent short steps of a large system in "
             "parallel; simulated distributes the components over nodes of a simulated network (default: sequential)");
  command
      ->add_option("--threads", a.run.threads,
                   "worker threads of --engine=threads and --engine=batch (default: one per processor)")
      ->check(CLI::Range(1, 256))
      ->type_name("N");
  command->add_option("--nodes", a.run.nodes, "number of nodes of --engine=simulated (default: 4)")
      ->check(CLI::Range(1u, rt::kMostNodes))
      ->type_name("N");
  command
      ->add_option("--placement", a.placement_path,
                   "place components on nodes as this file says (default: breadth first along connectors)")
      ->type_name("PATH")
      ->excludes("--nodes");
  command
      ->add_option("--faults", a.run.network_faults,
                   "what goes wrong in the simulated network, for example 'cut 1-2 3s..5s, crash 3 5s, slow 2 x10, "
                   "lose 5%, double 5%'")
      ->type_name("FAULTS");
  add_choice(*command, "--on-loss", a.run.on_loss, kOnLoss, "stop|go-on",
             "after the crash of a node, stop the run or go on with what does not need it (default: stop)");
  command->add_flag("-a,--asap", a.run.asap,
                    "take each step at the earliest instant at which it is possible (for models with clocks)");
  command->add_flag_callback(
      "--real-time", [&a] { a.run.speed = a.run.speed > 0 ? a.run.speed : 1; },
      "run in real time (default: logical time, which passes without waiting)");
  command->add_option("--speed", a.run.speed, "run in real time, with F seconds of model time per second")
      ->check(is_speed())
      ->type_name("F");
  command->add_flag("--relaxed", a.run.relaxed,
                    "in real time, report a step that starts too late as a warning instead of an error");
  add_real_time_priority(*command, a.run.real_time_priority);
  command
      ->add_option("--events", a.run.events_path,
                   "read external events from PATH, one JSON object per line, ordered by time")
      ->type_name("PATH");
  command
      ->add_option("--record", a.run.record_path, "write the external events that arrive to PATH, as input of --replay")
      ->type_name("PATH");
  command
      ->add_option("--replay", a.run.replay_path,
                   "repeat the run recorded in PATH, in logical time, with the recorded seed and policy")
      ->type_name("PATH");
  command->add_flag("-s,--silent", a.run.silent, "print no steps, only the seed and how the run ended");
  command->add_flag("--show-state", a.run.show_state, "print the places and data of each component at the end");
  // The published engine's words for what a run does anyway.
  command->add_flag_callback("-v,--verbose", [&a] { a.run.silent = false; })->group("");
  command->add_flag_callback("--execute", [&a] { a.run.explore = false; })->group("");
  command->set_version_flag("-V,--version")->group("");
  command->add_flag("--stats", a.run.stats,
                    "print the number of steps, the duration, the time per step and the memory used at the end");
  command->add_flag("-d,--debug", a.run.debug, "print the candidates of each state");
  command->add_flag("-i,--interactive", a.run.interactive, "choose each step by its number, read from standard input");
  command->add_flag(
      "--explore", a.run.explore,
      "count all reachable states, deadlocks and errors instead of running; --limit then limits the states");
  add_code_options(*command, a);
  command->add_flag_callback(
      "-f,--first-enabled", [&a] { a.run.policy = rt::Policy::First; }, "same as --policy first");
  command->add_flag_callback(
      "--disable-maximal-progress", [&a] { a.run.maximal_progress = false; },
      "disable maximal progress: an interaction may fire although a larger one of its connector is enabled");
  add_compile(*command, a.compile);
  command->footer(
      "Exit code: 0 at the limit, at a final state or at a deadlock, 1 after a run-time error (division by zero ...), "
      "130 after Ctrl-C.\n"
      "Example:\n  bipc run --seed 42 --limit 20 --root 'Ring(5)' model.bip");
}

void add_verify(CLI::App& app, VerifyArguments& a) {
  CLI::App* command = app.add_subcommand("verify", "prove that a model never deadlocks, or show a run that does");
  command->add_option("FILE", a.file, "model file (.bip or .bsys)")->required()->type_name("");
  command
      ->add_option(
          "--property", a.property,
          "property to decide: deadlock, errors, the name of a property of the model, 'never EXPR', 'always EXPR', or "
          "of runs: 'eventually EXPR', 'EXPR leads to EXPR', 'EXPR until EXPR' … (default: deadlock, and each property "
          "that the model states)")
      ->type_name("WHAT");
  command
      ->add_option("--properties", a.properties_path,
                   "read more properties of the model from PATH: `property NAME { … }` as in a compound")
      ->type_name("PATH");
  command
      ->add_option_function<std::string>(
          "--fair", [&a](const std::string& name) { a.fairness = *verify::read_fairness(name); },
          "runs that count for a property of runs: all (none, default), those in which whatever stays possible happens "
          "(weak), or whatever is possible again and again (strong); for each interaction, or for each component")
      ->check(CLI::IsMember(verify::fairness_names()))
      ->type_name("none|weak|strong|weak:atoms|strong:atoms");
  command->add_option("--timeout", a.timeout, "give up after SECONDS of processor time (default: 60)")
      ->check(is_number())
      ->type_name("SECONDS");
  command
      ->add_option("--memory", a.megabytes,
                   "memory limit for the states that a search stores, and for the circuit (default: 2048)")
      ->check(is_number())
      ->type_name("MB");
  command
      ->add_option("--certificate", a.certificate,
                   "write a certificate of the proof to PATH, for the checker certcheck")
      ->type_name("PATH");
  command
      ->add_flag("--partial", a.partial,
                 "decide whether some components can wait forever while others move (local deadlock)")
      ->excludes("--property")
      ->excludes("--certificate");
  command
      ->add_option("--trace", a.trace_path,
                   "write a trace (JSON lines) of the run that violates the property to PATH, for `bipc step`")
      ->type_name("PATH");
  command->add_flag("--why", a.why, "print the invariants that the proof uses");
  command
      ->add_option("--log",
                   "write what the algorithms do to standard error: AREA[:LEVEL],... of affine, components, houdini, "
                   "ic3, places, portfolio, time, traps; level 1 (default) to 3; only in a build with BIPC_LOG")
      ->check(CLI::Validator([](std::string& list) { return set_log_levels(list); }, ""))
      ->type_name("AREAS");
  command->add_flag("--json", a.json, "print the verdict as JSON");
  command->add_flag("--stats", a.stats, "print the processor time and how much was reused from earlier proofs");
  add_choice(*command, "--backend", a.backend, kBackends, "jit|interp",
             "executor of guards, actions and transfers during a search (default: jit if it is built in)");
  command->add_flag_callback(
      "--no-reuse", [&a] { a.reuses = false; }, "neither read nor write the proof cache");
  add_cache_options(*command, a.compile.cache);
  add_no_cpp(*command, a.compile);
  add_compile(*command, a.compile);
  command->footer(
      "EXPR is a condition on stable states: a@PLACE, a.data, can connector, can a.port, and the operators of guards.\n"
      "A property of runs has always, never, eventually, next before and leads to, until, unless, implies between its "
      "parts,\nand happens connector, happens a.port for the step that is taken.\n"
      "Exit code: 0 the property holds, 3 it is violated (a run is printed), 4 unknown. Ctrl-C prints what is known "
      "and ends with 4.\n"
      "Example:\n  bipc verify --root 'Table(1000)' --certificate table.cert model.bip\n"
      "  bipc verify --property 'never phil[0]@EATS && phil[1]@EATS' model.bip\n"
      "  bipc verify --property 'phil[0]@HUNGRY leads to phil[0]@EATS' --fair=weak model.bip\n"
      "  bipc verify --property errors model.bip");
}

void add_explore(CLI::App& app, ExploreArguments& a) {
  CLI::App* command =
      app.add_subcommand("explore", "visit all reachable states: count them, find deadlocks and run-time errors");
  command->add_option("FILE", a.file, "model file (.bip or .bsys)")->required()->type_name("");
  add_choice(*command, "--reduce", a.explore.reduction, kReductions, "none|por|symmetry",
             "visit fewer states: por (partial order reduction) keeps all deadlocks, symmetry merges states that "
             "differ by a permutation of equal components (default: none)");
  command->add_option("--threads", a.threads, "number of worker threads (default: one per processor)")
      ->check(is_number())
      ->type_name("N");
  command
      ->add_option("--memory", a.megabytes, "memory limit of the search (default: three quarters of the free memory)")
      ->check(is_number())
      ->type_name("MB");
  command->add_option("--timeout", a.seconds, "stop after SECONDS (default: no limit)")
      ->check(is_number())
      ->type_name("SECONDS");
  command->add_option("--limit", a.explore.limit, "stop after N states (default: no limit)")
      ->check(is_number())
      ->type_name("N");
  command->add_flag("--json", a.json, "print the result as JSON");
  command
      ->add_option("--trace", a.trace_path,
                   "write a trace that leads to the deadlock, or to the error if there is no deadlock, to PATH "
                   "(default format: json)")
      ->type_name("PATH");
  add_choice(*command, "--trace-format", a.format, kTextFormats.names, kTextFormats.shown,
             "format of the trace" + kTextFormats.help);
  command->add_flag("--silent", a.silent, "print only the summary line");
  command->add_flag("--stats", a.stats, "print states per second, bytes per state and the depth at the end");
  command->add_flag("--trust-cpp", a.trusts_cpp,
                    "assume that the model's C++ functions depend on their arguments only");
  add_choice(*command, "--backend", a.backend, kBackends, "jit|interp",
             "executor of guards, actions and transfers (default: jit if it is built in)");
  add_cache_options(*command, a.compile.cache);
  add_no_cpp(*command, a.compile);
  add_optimisation(*command, a.optimisation, CompilerLevels::O0O2,
                   "optimisation level of the JIT (default: 2 for at most 32 functions, else 0)");
  command->add_flag_callback(
      "--disable-maximal-progress", [&a] { a.explore.progress = rt::MaximalProgress::Off; },
      "disable maximal progress: an interaction may fire although a larger one of its connector is enabled");
  add_compile(*command, a.compile);
  command->footer(
      "Exit code: 0 all states visited, no error, no deadlock; 1 run-time errors; 3 deadlocks; 4 a limit was reached. "
      "Ctrl-C prints what is known.\n"
      "Example:\n  bipc explore --root 'Table(12)' --trace dead.txt --trace-format bip2 model.bip && bipc replay "
      "--published dead.txt --root 'Table(12)' model.bip");
}

void add_simulate(CLI::App& app, SimulateArguments& a) {
  CLI::App* command =
      app.add_subcommand("simulate", "make many runs and estimate numbers: counts, times, probabilities");
  command->add_option("FILE", a.file, "model file (.bip or .bsys)")->required()->type_name("");
  command->add_option("--runs", a.simulate.runs, "number of runs (default: 1000)")->check(is_number())->type_name("N");
  command
      ->add_option("--within", a.within,
                   "make so many runs that a probability is known within E, with confidence 95% (instead of --runs)")
      ->check(CLI::Range(0.0001, 0.5))
      ->type_name("E");
  add_seed(*command, a.simulate.seed, a.has_seed,
           "seed of the first run; each later run has the next number (default: drawn at random and printed)");
  command->add_option("-l,--limit", a.simulate.limit, "steps of a run (default: 1000)")
      ->check(is_number())
      ->type_name("N");
  command
      ->add_option("--until", a.until, "end each run at this instant of the model, such as 1s500ms (default: no limit)")
      ->type_name("TIME");
  command
      ->add_option("--observe", a.observers,
                   "measure in each run: count NAME, reaches EXPR, time until EXPR, duration of EXPR, max EXPR, min "
                   "EXPR, mean EXPR, last EXPR")
      ->type_name("OBSERVER")
      ->allow_extra_args(false);
  command->add_option("--stop", a.stop, "end a run at the first state in which the condition EXPR holds")
      ->type_name("EXPR");
  add_choice(*command, "--policy", a.simulate.policy, kPolicies.names, kPolicies.shown,
             "how the next step is chosen among the candidates (default: uniform)");
  command->add_flag("-a,--asap", a.simulate.asap,
                    "with time, take each step at the first instant at which one is possible");
  command->add_option("--threads", a.threads, "number of worker threads (default: one per processor)")
      ->check(is_number())
      ->type_name("N");
  command->add_flag("--histogram", a.shows_histogram, "print how often each value was observed, in 20 bins");
  command->add_flag("--json", a.json, "print the result as JSON");
  command->add_option("--csv", a.csv_path, "write a row for each run to PATH")->type_name("PATH");
  add_choice(*command, "--backend", a.backend, kBackends, "jit|interp",
             "executor of guards, actions and transfers (default: jit if it is built in)");
  add_cache_options(*command, a.compile.cache);
  add_no_cpp(*command, a.compile);
  add_optimisation(*command, a.optimisation, CompilerLevels::O0O2,
                   "optimisation level of the JIT (default: 2 for at most 32 functions or many steps, else 0)");
  command->add_flag_callback(
      "--disable-maximal-progress", [&a] { a.simulate.progress = rt::MaximalProgress::Off; },
      "disable maximal progress: an interaction may fire although a larger one of its connector is enabled");
  add_compile(*command, a.compile);
  command->footer(
      "EXPR is an expression over stable states: a@PLACE, a.data, can connector, can a.port, and the operators of "
      "guards. Times are in seconds; without clocks, in steps.\n"
      "Run k is `bipc run --seed SEED+k`. The result does not depend on the number of threads.\n"
      "Exit code: 0, or 1 if a run ended with a run-time error, 130 after Ctrl-C.\n"
      "Example:\n  bipc simulate --runs 10000 --limit 100 --observe 'count table.eat[0]' --observe 'reaches "
      "phil[0]@EATS' model.bip");
}

// How a debugging session's steps are chosen.
void add_session(CLI::App& command, SessionArguments& a, CLI::Option* trace) {
  rt::SessionOptions& session = a.session;
  command.add_option("--seed", session.seed, "seed of the random choices (default: 0)")
      ->check(is_number())
      ->type_name("N");
  add_choice(command, "--policy", session.policy, kPolicies.names, kPolicies.shown,
             "how the next step is chosen among the candidates (default: uniform)");
  command.add_flag("-a,--asap", session.asap,
                   "take each step at the earliest instant at which it is possible (for models with clocks)");
  command
      .add_option("--events", a.events_path,
                  "read external events from PATH, one JSON object per line, ordered by time")
      ->excludes(trace)
      ->type_name("PATH");
  command.add_flag("--trust-cpp", session.trusts_cpp,
                   "assume that the model's C++ functions depend on their arguments only, so that the session can go "
                   "back");
  command.add_flag_callback(
      "--disable-maximal-progress", [&session] { session.progress = rt::MaximalProgress::Off; },
      "disable maximal progress: an interaction may fire although a larger one of its connector is enabled");
  add_choice(command, "--backend", a.backend, kBackends, "jit|interp",
             "executor of guards, actions and transfers (default: interp)");
}

void add_step(CLI::App& app, StepArguments& a) {
  CLI::App* command = app.add_subcommand(
      "step", "step through a model, forward and back, with breakpoints: commands are read from the terminal");
  command->add_option("FILE", a.file, "model file (.bip or .bsys)")->required()->type_name("");
  CLI::Option* trace = command->add_option("--trace", a.trace_path,
                                           "begin at the end of the run in TRACE: a trace in JSON lines, binary or "
                                           "bip2, or a record of `bipc run --record`");
  trace->type_name("TRACE");
  command
      ->add_option_function<std::uint64_t>(
          "--at",
          [&a](const std::uint64_t& at) {
            a.at = at;
            a.has_at = true;
          },
          "begin after N moves of the trace")
      ->check(is_number())
      ->needs(trace)
      ->type_name("N");
  add_session(*command, a, trace);
  add_cache_options(*command, a.compile.cache);
  add_no_cpp(*command, a.compile);
  add_compile(*command, a.compile);
  command->footer(
      "The command `h` lists all commands. Input that is no terminal is repeated before each answer; a command that is "
      "refused then gives exit code 2.\n"
      "Example:\n  bipc verify --trace dead.json model.bip; bipc step --trace dead.json model.bip");
}

void add_dap(CLI::App& app) {
  CLI::App* command = app.add_subcommand("dap", "serve an editor as a debug adapter, on standard input and output");
  command->footer(
      "An editor starts it and names the model in the request `launch`, see compiler/docs/dap.md; the session is that "
      "of `bipc step`.\n"
      "Exit code: 0 after `disconnect`, 1 if the input ends before.\nExample:\n  bipc dap");
}

void add_serve(CLI::App& app, ServeArguments& a) {
  CLI::App* command =
      app.add_subcommand("serve", "run a model in real time while clients post events, observe it and control it");
  command->add_option("FILE", a.file, "model file (.bip or .bsys)")->required()->type_name("");
  command
      ->add_option("--socket", a.socket,
                   "accept clients at the Unix socket PATH (default: one client, on standard input and output)")
      ->type_name("PATH");
  command
      ->add_option_function<std::uint16_t>(
          "--port",
          [&a](const std::uint16_t& port) {
            a.port = port;
            a.has_port = true;
          },
          "accept clients at TCP port N of 127.0.0.1 (0: a free one) that know the token printed to standard error")
      ->check(is_number())
      ->type_name("N");
  command->add_flag("--paused", a.paused, "start paused, until a client sends `resume` or `step`");
  command->add_option("--seed", a.seed, "seed of the random choices (default: 0)")->check(is_number())->type_name("N");
  add_choice(*command, "--policy", a.policy, kPolicies.names, kPolicies.shown,
             "how the next step is chosen among the candidates (default: uniform)");
  add_choice(*command, "--backend", a.backend, kBackends, "jit|interp",
             "executor of guards, actions and transfers (default: jit if it is built in)");
  add_cache_options(*command, a.compile.cache);
  add_no_cpp(*command, a.compile);
  command->add_flag("--asap", a.asap, "take each step at the earliest instant at which it is possible");
  command->add_option("--speed", a.speed, "seconds of model time per second (default: 1)")
      ->check(is_speed())
      ->type_name("F");
  add_real_time_priority(*command, a.real_time_priority);
  add_duration(*command, "--stall-after", a.stall_after,
               "when no step has returned for so long, or steps begin so much too late, say so and call the safe-stop "
               "function (default: 1s if the model's C++ has one, else 0: never)");
  command
      ->add_option("--safe-stop", a.safe_stop,
                   "the C function of the model's C++ that stops the robot, `extern \"C\" void NAME(const char* why)` "
                   "(default: safe_stop, if there is one)")
      ->type_name("NAME");
  add_duration(*command, "--late-after", a.late_after,
               "tell of each instant whose steps begin so much later than they are due (default: 0: never)");
  command
      ->add_option("--trace", a.trace_path,
                   "write a trace of the steps to PATH; the file is complete when the process has ended")
      ->type_name("PATH");
  add_choice(*command, "--trace-format", a.trace_format, kServedFormats.names, kServedFormats.shown,
             "format of the trace" + kServedFormats.help + " (default: json)");
  add_compile(*command, a.compile);
  command->footer(
      "Requests and answers are lines of JSON, see compiler/docs/serve.md; tools/serve_client.py is an example of a "
      "client.\n"
      "Example:\n  echo '{\"do\":\"hello\"}' | bipc serve model.bip");
}

void add_build(CLI::App& app, BuildArguments& a) {
  CLI::App* command = app.add_subcommand("build", "build a stand-alone program with the host's C++ compiler");
  command->add_option("FILE", a.file, "model file (.bip or .bsys)")->required()->type_name("");
  command->add_option("-o,--output", a.output, "program to write")->required()->type_name("EXE");
  add_optimisation(*command, a.optimisation, CompilerLevels::O0O1O2,
                   "optimisation level of the C++ compiler (default: 3)");
  add_compile(*command, a.compile);
  add_no_cpp(*command, a.compile);
  command->footer(
      "The compiler is $CXX, else c++, g++ or clang++.\nExample:\n  bipc build model.bip -o model && ./model --seed "
      "42");
}

void add_emit(CLI::App& app, EmitArguments& a) {
  CLI::App* command =
      app.add_subcommand("emit", "write the C++ code of a model, or print the product of a compiler stage");
  command->add_option("FILE", a.file, "model file (.bip or .bsys)")->required()->type_name("");
  command->add_option("-o,--output", a.directory, "write model.cpp, CMakeLists.txt and the runtime's sources to DIR")
      ->type_name("DIR");
  command
      ->add_option("--namespace", a.compile.cpp_namespace,
                   "put the C++ code into namespace NAME, without main(), so that several models fit into one program; "
                   "NAME::image() is the model, NAME_image() in C")
      ->check(CLI::Validator(
          [](std::string& text) {
            return is_namespace(text) ? std::string() : fmt::format("`{}` is not the name of a C++ namespace", text);
          },
          ""))
      ->excludes("--output")
      ->type_name("NAME");
  add_optimisation(*command, a.optimisation, CompilerLevels::O0O2,
                   "optimisation level for --emit=llvm and --emit=asm (default: 2)");
  add_compile(*command, a.compile);
  command->footer(
      "Without -o the C++ code (or the stage that --emit names) is written to standard output.\nExample:\n  bipc emit "
      "model.bip -o generated");
}

// What a picture shows of a large system.
void add_folding(CLI::App& command, graph::PictureOptions& picture) {
  command.add_option("--fold", picture.fold, "draw arrays of more than N components as one box (default: 8)")
      ->check(is_number())
      ->type_name("N");
  command
      .add_option("--depth", picture.depth, "draw compounds N levels below the root as closed boxes (default: none)")
      ->check(is_number())
      ->type_name("N");
  command
      .add_option("--bundle", picture.bundle,
                  "in compounds with more than N connectors draw those that join the same closed boxes as one line "
                  "(default: 60)")
      ->check(is_number())
      ->type_name("N");
  command
      .add_option("--open", picture.open,
                  "draw the array or compound PATH open all the same, `phil` or `line.before`; may be repeated")
      ->allow_extra_args(false)
      ->type_name("PATH");
}

void add_graph(CLI::App& app, GraphArguments& a) {
  CLI::App* command =
      app.add_subcommand("graph", "draw a system: components, ports, connectors, automata; or print it as DOT or JSON");
  command->add_option("FILE", a.file, "model file (.bip or .bsys)")->required()->type_name("");
  command->add_option("-o,--output", a.output, "write the picture to FILE; its suffix says the format")
      ->type_name("FILE");
  add_choice(*command, "--format", a.format, kGraphFormats, "svg|png|html|dot|json",
             "output format: svg (a picture), png (the same, by the program rsvg-convert), html (a page to look around "
             "in), dot for Graphviz (default without -o) or json");
  add_choice(*command, "--show", a.picture.show, kShows, "all|structure|automata",
             "what to show: instances and connectors (structure), the automaton of each atom type (automata), or both "
             "(all, default)");
  add_folding(*command, a.picture);
  add_compile(*command, a.compile);
  command->footer("Example:\n  bipc graph model.bip -o model.svg");
}

void add_view(CLI::App& app, ViewArguments& a) {
  CLI::App* command = app.add_subcommand(
      "view", "write a page that shows a model and a run of it, step by step, in a browser: one file without requests");
  command->add_option("FILE", a.file, "model file (.bip or .bsys)")->required()->type_name("");
  command->add_option("-o,--output", a.output, "page to write (default: the model's name with .html)")
      ->type_name("PAGE");
  CLI::Option* trace =
      command->add_option("--trace", a.trace_path,
                          "show the run in TRACE: a trace in JSON lines, binary or bip2, a "
                          "counterexample of `bipc verify --trace`, or a record of `bipc run --record`");
  trace->type_name("TRACE");
  command
      ->add_option("--steps", a.steps,
                   "show a run of at most N steps (default: 200); more than 100000 make a page too large for browsers")
      ->check(is_number())
      ->excludes(trace)
      ->type_name("N");
  add_session(*command, a, trace);
  add_folding(*command, a.picture);
  add_cache_options(*command, a.compile.cache);
  add_no_cpp(*command, a.compile);
  add_compile(*command, a.compile);
  command->footer(
      "Example:\n  bipc verify --trace dead.json model.bip; bipc view --trace dead.json model.bip -o model.html");
}

void add_export(CLI::App& app, ExportArguments& a) {
  CLI::App* command = app.add_subcommand(
      "export",
      "write a model for other tools: Promela for SPIN, PNML for Petri nets, AIGER for model checkers of circuits");
  command->add_option("FILE", a.file, "model file (.bip or .bsys)")->required()->type_name("");
  add_choice(
      *command, "--format", a.format, kExportFormats, "promela|pnml|aiger|net",
      "output format: promela (default; int, bool and string data), pnml (models without guards over data), aiger "
      "(the prover's transition system as an and-inverter graph, with one output: bad) or net (the prover's net as "
      "a DOT graph)");
  command
      ->add_option("--property", a.property,
                   "property whose violation is bad in the format aiger (default: deadlock), as for verify")
      ->type_name("PROPERTY");
  command->add_option("-o,--output", a.output, "output file (default: standard output)")->type_name("FILE");
  command->add_flag_callback(
      "--disable-maximal-progress", [&a] { a.maximal_progress = false; },
      "disable maximal progress: an interaction may fire although a larger one of its connector is enabled");
  add_compile(*command, a.compile);
  command->footer(
      "Example:\n  bipc export --root 'Table(5)' model.bip -o m.pml && spin -a m.pml && cc -O2 -fwrapv -DSAFETY -o pan "
      "pan.c && ./pan");
}

void add_fmt(CLI::App& app, FmtArguments& a) {
  CLI::App* command = app.add_subcommand("fmt", "print models in the standard layout");
  command->add_option("FILE", a.files, "model files (.bip)")->required()->type_name("");
  CLI::Option* check = command->add_flag(
      "--check", a.check, "print only the names of files whose layout differs; exit code 1 if there is one");
  command->add_flag("-i,--in-place", a.in_place, "rewrite the files in place instead of printing them")
      ->excludes(check);
  add_diagnostics(*command, a.compile);
  command->footer("Example:\n  bipc fmt -i model.bip");
}

void add_explain(CLI::App& app, Arguments& a) {
  CLI::App* command = app.add_subcommand("explain", "explain a diagnostic code with a wrong and a right example");
  command->add_option("CODE", a.explain_code, "diagnostic code, for example B1001 or R0005 (default: list all codes)")
      ->type_name("");
  add_color(*command, a.explain_color);
  command->footer("Example:\n  bipc explain R0005");
}

void add_completion(CLI::App& app, Shell& shell) {
  CLI::App* command = app.add_subcommand("completion", "print the completion script of a shell");
  command
      ->add_option_function<std::string>(
          "SHELL", [&shell](const std::string& text) { shell = kShells.at(text); }, "bash, zsh or fish")
      ->check(CLI::Validator(
          [](std::string& text) { return kShells.contains(text) ? "" : not_one_of(text, "bash|zsh|fish"); }, ""))
      ->required()
      ->type_name("");
  command->footer("Example:\n  source <(bipc completion bash)");
}

void add_version(CLI::App& app, VersionArguments& a) {
  CLI::App* command = app.add_subcommand("version", "print the version and the available back ends");
  command->add_flag_callback(
      "--json", [&a] { a.format = VersionFormat::Json; },
      "print version, commit, version of LLVM and the paths of all parts as JSON");
  command->footer("Example:\n  bipc version --json");
}

// The published tools' call has no command word; its options stand on the program itself.
void add_published(CLI::App& app, PublishedArguments& a) {
  const char* group = "As the published tools are called";
  CLI::Option* package =
      app.add_option("-p", a.package, "check the package PACKAGE, whose file is PACKAGE.bip in a folder given by -I");
  package->type_name("PACKAGE")->group(group);
  CLI::Option* file = app.add_option("-f", a.file, "check the file FILE instead of one found by its package");
  file->type_name("FILE")->group(group);
  app.add_option("-I", a.compile.folders, "search DIR for packages; may be repeated (default: current folder)")
      ->allow_extra_args(false)
      ->type_name("DIR")
      ->group(group);
  app.add_option("-d", a.compile.root, "root component, for example 'Root()'")->type_name("TYPE(ARGS)")->group(group);
  app.add_option("--gencpp-output,--gencpp-output-dir", a.cpp_output, "write C++ code to DIR")
      ->type_name("DIR")
      ->group(group);
  app.add_flag("--Werr,--WError,--Werror", a.compile.warnings_are_errors,
               "treat all warnings as errors; also written -WError")
      ->group(group);
  app.add_option_function<std::string>(
         "-W", [&a](const std::string&) { a.compile.warnings_are_errors = true; }, "--Werr, written -WError or -WErr")
      ->check(CLI::Validator(
          [](std::string& text) { return text == "Error" || text == "Err" ? "" : not_one_of(text, "Error, Err"); }, ""))
      ->group("");
  add_choice(app, "--diagnostics", a.compile.render.format, kFormats, "frame|short|json|sarif",
             "format of errors and warnings (default: frame)", group);
  app.add_option("--gencpp-cc-I", a.cpp_folders, "search DIR for files that `@cpp` names; may be repeated")
      ->allow_extra_args(false)
      ->type_name("DIR")
      ->group(group);
  app.add_flag("--gencpp-no-main", a.has_no_main, "write C++ code without `main`: `model::image()` is the model")
      ->group(group);
  // What steers the published C++ back end and its makefiles. `bipc emit` writes its own CMakeLists.txt.
  for (const char* name :
       {"--gencpp-cc-extra-src", "--gencpp-cc-extra-obj", "--gencpp-ld-L", "--gencpp-ld-l", "--gencpp-ld-extra-obj",
        "--gencpp-cc-extra-opt", "--gencpp-optim", "--gencpp-set-optim-param", "--gencpp-disable-optim"}) {
    app.add_option_function<std::vector<std::string>>(
           name, [&a, name](const std::vector<std::string>&) { a.ignored.emplace_back(name); }, "")
        ->allow_extra_args(false)
        ->group("");
  }
  for (const char* name : {"--gencpp-follow-used-packages", "--gencpp-enable-optim", "--gencpp-enable-bip-debug",
                           "--gencpp-enable-marshalling", "--gencpp-no-serial"}) {
    app.add_flag_callback(
           name, [&a, name] { a.ignored.emplace_back(name); }, "")
        ->group("");
  }
}

void add_replay(CLI::App& app, ReplayArguments& a) {
  CLI::App* command =
      app.add_subcommand("replay", "follow a recorded run and compare each of its states with the model");
  command->add_option("FILE", a.file, "model file (.bip or .bsys)")->required()->type_name("");
  CLI::Option* published =
      command
          ->add_option("--published", a.published_trace,
                       "trace in the text format of the published engine (as written by --trace-format=bip2)")
          ->type_name("TRACE");
  command
      ->add_option("--recorded", a.recorded_trace,
                   "binary trace (as written by `bipc run --trace-format=binary`); its steps are printed")
      ->type_name("TRACE")
      ->excludes(published);
  add_choice(*command, "--trace-format", a.format, kTextFormats.names, kTextFormats.shown,
             "with --recorded, format of the printed steps (default: steps)");
  command->add_flag("--silent", a.silent, "with --recorded, print no steps");
  add_choice(*command, "--backend", a.backend, kBackends, "jit|interp",
             "executor of guards, actions and transfers (default: jit if it is built in)");
  command->add_flag_callback(
      "--disable-maximal-progress", [&a] { a.maximal_progress = false; },
      "the recorded run had maximal progress disabled");
  add_compile(*command, a.compile);
  add_no_cpp(*command, a.compile);
  command->footer(
      "--published takes the steps of TRACE and compares the candidates of each state, in any order: names, values, "
      "intervals.\n--recorded checks that each step is a candidate where it is taken and that the last state is the "
      "recorded one.\n"
      "The first difference is printed and ends the command with exit code 1.\n"
      "Example:\n  bipc replay --published run.txt model.bip\n"
      "  bipc run --seed 1 --limit 100 --trace run.bin --trace-format binary model.bip && bipc replay --recorded "
      "run.bin model.bip");
}

void add_migrate(CLI::App& app, MigrateArguments& a) {
  CLI::App* command = app.add_subcommand("migrate", "print models with obsolete spellings replaced by current ones");
  command->add_option("FILE", a.files, "model files (.bip)")->required()->type_name("");
  command->add_flag("-i,--in-place", a.in_place, "rewrite the files in place instead of printing them");
  add_folders(*command, a.compile);
  add_diagnostics(*command, a.compile);
  command->footer("Layout and comments are kept.\nExample:\n  bipc migrate -i model.bip");
}

}  // namespace

void add_commands(CLI::App& app, Arguments& arguments) {
  add_published(app, arguments.published);
  add_check(app, arguments.check);
  add_run(app, arguments.run);
  add_verify(app, arguments.verify);
  add_explore(app, arguments.explore);
  add_simulate(app, arguments.simulate);
  add_step(app, arguments.step);
  add_view(app, arguments.view);
  add_dap(app);
  add_serve(app, arguments.serve);
  add_build(app, arguments.build);
  add_emit(app, arguments.emit);
  add_graph(app, arguments.graph);
  add_export(app, arguments.exported);
  add_replay(app, arguments.replay);
  add_fmt(app, arguments.fmt);
  add_migrate(app, arguments.migrate);
  add_genom(app, arguments.genom);
  add_rules(app, arguments.rules);
  add_explain(app, arguments);
  add_completion(app, arguments.shell);
  add_version(app, arguments.version);
}

}  // namespace bip::driver
