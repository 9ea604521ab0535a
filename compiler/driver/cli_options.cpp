// One function a command: its description, its options, its example.
#include "compiler/driver/cli_options.hpp"

#include <map>

namespace bip::driver {
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
const Names<EmitKind> kGraphFormats{{"dot", EmitKind::Dot}, {"json", EmitKind::Json}};
const Names<graph::Show> kShows{
    {"all", graph::Show::All}, {"structure", graph::Show::Structure}, {"automata", graph::Show::Automata}};
const Names<Backend> kBackends{{"jit", Backend::Jit}, {"interp", Backend::Interp}};
const Names<rt::Policy> kPolicies{
    {"uniform", rt::Policy::Uniform}, {"first", rt::Policy::First}, {"fair", rt::Policy::Fair}};
const Names<rt::TraceFormat> kTraceFormats{
    {"steps", rt::TraceFormat::Steps}, {"json", rt::TraceFormat::Json}, {"bip2", rt::TraceFormat::Bip2}};
const Names<rt::TraceFormat> kRecordFormats{{"steps", rt::TraceFormat::Steps}, {"json", rt::TraceFormat::Json},
                                            {"bip2", rt::TraceFormat::Bip2},   {"binary", rt::TraceFormat::Binary},
                                            {"mcap", rt::TraceFormat::Mcap},   {"perfetto", rt::TraceFormat::Perfetto}};
const Names<rt::TraceFormat> kServedFormats{
    {"json", rt::TraceFormat::Json}, {"mcap", rt::TraceFormat::Mcap}, {"perfetto", rt::TraceFormat::Perfetto}};
const Names<rt::Engine> kEngines{
    {"sequential", rt::Engine::Sequential}, {"threads", rt::Engine::Threads}, {"batch", rt::Engine::Batch}};

const Names<ExportFormat> kExportFormats{{"promela", ExportFormat::Promela}, {"pnml", ExportFormat::Pnml}};
const Names<rt::Reduction> kReductions{
    {"none", rt::Reduction::None}, {"por", rt::Reduction::Por}, {"symmetry", rt::Reduction::Symmetry}};

std::string not_one_of(const std::string& text, const std::string& shown) {
  return fmt::format("`{}` is not one of {}", text, shown);
}

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
  add_choice(app, "--color", color, kColors, "auto|always|never", "colour; auto is a terminal without NO_COLOR");
}

void add_diagnostics(CLI::App& app, CompileOptions& options) {
  add_choice(app, "--diagnostics", options.render.format, kFormats, "frame|short|json|sarif",
             "how errors and warnings look");
  add_color(app, options.color);
  app.add_flag("--Werror", options.fatal_warnings,
               "warnings count as errors; --Werror=CODE, as often as needed: those of the code")
      ->check(CLI::Validator(
          [](std::string& text) {
            const std::optional<Diag> kind = find_diag(text);
            if (text == "true" || (kind && info(*kind).severity == Severity::Warning)) return std::string();
            return fmt::format("`{}` is not the code of a warning", text);
          },
          ""));
  app.add_flag("--explain", options.explain, "the page of the first error follows (else of the first warning)");
}

void add_folders(CLI::App& app, CompileOptions& options) {
  app.add_option("-I", options.folders,
                 "where used packages are; the file's own folder and the standard library follow")
      ->allow_extra_args(false)
      ->type_name("DIR");
}

void add_compile(CLI::App& app, CompileOptions& options) {
  add_folders(app, options);
  app.add_option("--root", options.root,
                 "root component, 'Ring(10)'; else the one parameterless compound nobody instantiates")
      ->type_name("TYPE(ARGS)");
  add_choice(app, "--emit", options.emit, kEmits, "tokens|syntax|model|system|llvm|asm|cpp|dot|json",
             "print this stage's product and stop");
  app.add_flag("--time-passes", options.time_passes, "print how long each pass took to standard error");
  app.add_flag("--verify-each", options.verify_each, "check the compiler's own promises after each pass");
  add_diagnostics(app, options);
}

void add_check(CLI::App& app, CheckArguments& a) {
  CLI::App* command = app.add_subcommand("check", "report all errors and warnings of models, nothing else");
  command->add_option("FILE", a.files, ".bip or .bsys files")->required()->type_name("");
  add_compile(*command, a.compile);
  command->footer("Example:\n  bipc check --diagnostics=short model.bip");
}

void add_run(CLI::App& app, RunArguments& a) {
  CLI::App* command = app.add_subcommand("run", "run a model and print its steps");
  command
      ->add_option("FILE", a.file,
                   "a .bip or .bsys file, or a folder with a program `run`, which gets --seed and --speed")
      ->required()
      ->type_name("");
  command
      ->add_option_function<std::uint64_t>(
          "--seed",
          [&a](const std::uint64_t& seed) {
            a.run.seed = seed;
            a.run.has_seed = true;
          },
          "of the random choices; without it one is drawn and printed")
      ->check(is_number())
      ->type_name("N");
  command->add_option("--limit", a.run.limit, "stop after N steps")->check(is_number())->type_name("N");
  add_choice(*command, "--policy", a.run.policy, kPolicies, "uniform|first|fair",
             "which of the possible steps is taken");
  add_choice(*command, "--backend", a.backend, kBackends, "jit|interp", "what executes guards, actions and transfers");
  add_cache_options(*command, a.compile.cache);
  add_optimisation(
      *command, a.optimisation, false,
      "JIT optimisation before the first step; by itself a run begins interpreted and gets -O2 while it runs");
  command->add_option("--trace", a.run.trace_path, "write the run to PATH, as JSON lines or as --trace-format says")
      ->type_name("PATH");
  add_choice(*command, "--trace-format", a.run.format, kRecordFormats, "steps|json|bip2|binary|mcap|perfetto",
             "form of the steps; bip2 is the reference engine's, binary is for `bipc replay`, mcap for Foxglove, "
             "perfetto for ui.perfetto.dev");
  add_choice(*command, "--engine", a.run.engine, kEngines, "sequential|threads|batch",
             "threads: long actions at the same time; batch: short steps of a large system, a part a thread");
  command->add_option("--threads", a.run.threads, "of these engines (default: one a processor)")
      ->check(CLI::Range(1, 256))
      ->type_name("N");
  command->add_flag("--asap", a.run.asap, "models with time: each step as soon as it is possible");
  command->add_flag_callback(
      "--real-time", [&a] { a.run.speed = a.run.speed > 0 ? a.run.speed : 1; },
      "time passes as on the wall clock; without, it is logical and nothing sleeps");
  command->add_option("--speed", a.run.speed, "--real-time, F seconds of the model a second")
      ->check(CLI::Range(1e-6, 1e6))
      ->type_name("F");
  command->add_flag("--relaxed", a.run.relaxed, "--real-time: a step that starts too late is a warning");
  add_real_time_priority(*command, a.run.real_time_priority);
  command
      ->add_option("--events", a.run.events_path, "events from outside, one a line of JSON, in the order of their time")
      ->type_name("PATH");
  command->add_option("--record", a.run.record_path, "write the events that come to PATH, for --replay")
      ->type_name("PATH");
  command
      ->add_option("--replay", a.run.replay_path,
                   "repeat the run that was recorded, in logical time, with its seed and policy")
      ->type_name("PATH");
  command->add_flag("--silent", a.run.silent, "no step lines; seed and end are still told");
  command->add_flag("--stats", a.run.stats, "steps, seconds, time a step and bytes at the end");
  command->add_flag("--debug", a.run.debug, "print every state's possible steps");
  command->add_flag("--interactive", a.run.interactive, "choose each step by its number, read from standard input");
  command->add_flag("--explore", a.run.explore,
                    "count all reachable states, deadlocks and errors; --limit is of states");
  add_code_options(*command, a);
  command->add_flag_callback(
      "--first-enabled", [&a] { a.run.policy = rt::Policy::First; }, "--policy first");
  command->add_flag_callback(
      "--disable-maximal-progress", [&a] { a.run.maximal_progress = false; },
      "smaller interactions may run although a larger one could");
  add_compile(*command, a.compile);
  command->footer(
      "A deadlock is a normal end: exit code 0. A run-time error (division by zero ...) ends with 1, Ctrl-C with 130.\n"
      "Example:\n  bipc run --seed 42 --limit 20 --root 'Ring(5)' model.bip");
}

void add_verify(CLI::App& app, VerifyArguments& a) {
  CLI::App* command = app.add_subcommand("verify", "prove that a model never deadlocks, or show how it does");
  command->add_option("FILE", a.file, "a .bip or .bsys file")->required()->type_name("");
  command
      ->add_option("--property", a.property, "what is asked: deadlock (default), errors, 'never EXPR' or 'always EXPR'")
      ->type_name("WHAT");
  command->add_option("--timeout", a.timeout, "give up after SECONDS of processor time (default 60)")
      ->check(is_number())
      ->type_name("SECONDS");
  command->add_option("--memory", a.megabytes, "of the states that a search keeps (default 2048)")
      ->check(is_number())
      ->type_name("MB");
  command->add_option("--certificate", a.certificate, "write the evidence of a proof to PATH")->type_name("PATH");
  command->add_flag("--partial", a.partial, "can a component wait for ever while others move")
      ->excludes("--property")
      ->excludes("--certificate");
  command->add_flag("--why", a.why, "print the invariants of a proof");
  command->add_flag("--json", a.json, "the verdict as JSON");
  command->add_flag("--stats", a.stats, "seconds of the processor, and what came from earlier proofs");
  add_choice(*command, "--backend", a.backend, kBackends, "jit|interp", "what executes code when states are searched");
  command->add_flag_callback(
      "--no-reuse", [&a] { a.reuses = false; }, "prove all anew; nothing of it is kept for the next time");
  add_cache_options(*command, a.compile.cache);
  add_compile(*command, a.compile);
  command->footer(
      "EXPR is about stable states: a@PLACE, a.data, can connector, can a.port, with the operators of guards.\n"
      "Exit code: 0 it holds, 3 it does not (the steps are shown), 4 unknown. Ctrl-C tells what is known and ends with "
      "4.\n"
      "Example:\n  bipc verify --root 'Table(1000)' --certificate table.cert model.bip\n"
      "  bipc verify --property 'never phil[0]@EATS && phil[1]@EATS' model.bip\n"
      "  bipc verify --property errors model.bip");
}

void add_explore(CLI::App& app, ExploreArguments& a) {
  CLI::App* command =
      app.add_subcommand("explore", "visit all reachable states: count them, find deadlocks and run-time errors");
  command->add_option("FILE", a.file, "a .bip or .bsys file")->required()->type_name("");
  add_choice(*command, "--reduce", a.explore.reduction, kReductions, "none|por|symmetry",
             "visit fewer: por keeps all deadlocks, symmetry counts interchangeable components once");
  command->add_option("--threads", a.threads, "that work (default: one a processor)")
      ->check(is_number())
      ->type_name("N");
  command->add_option("--memory", a.megabytes, "stop before more is used (default: three quarters of what is free)")
      ->check(is_number())
      ->type_name("MB");
  command->add_option("--timeout", a.seconds, "stop after SECONDS")->check(is_number())->type_name("SECONDS");
  command->add_option("--limit", a.explore.limit, "stop after N states")->check(is_number())->type_name("N");
  command->add_flag("--json", a.json, "the result as JSON");
  command
      ->add_option("--trace", a.trace_path,
                   "write the way to the deadlock (else to the error) to PATH, as JSON lines or as --trace-format says")
      ->type_name("PATH");
  add_choice(*command, "--trace-format", a.format, kTraceFormats, "steps|json|bip2",
             "bip2: the reference engine's own lines");
  command->add_flag("--silent", a.silent, "only the last line");
  command->add_flag("--stats", a.stats, "states a second, bytes a state, depth at the end");
  command->add_flag("--trust-cpp", a.trusts_cpp, "C++ functions of the model depend on nothing but their arguments");
  add_choice(*command, "--backend", a.backend, kBackends, "jit|interp", "what executes guards, actions and transfers");
  add_cache_options(*command, a.compile.cache);
  add_optimisation(*command, a.optimisation, false,
                   "JIT optimisation; by itself -O2 up to 32 pieces of code, else -O0");
  command->add_flag_callback(
      "--disable-maximal-progress", [&a] { a.explore.progress = rt::MaximalProgress::Off; },
      "smaller interactions may run although a larger one could");
  add_compile(*command, a.compile);
  command->footer(
      "Exit code: 0 all visited and nothing found, 1 run-time errors, 3 deadlocks, 4 a limit came first. Ctrl-C tells "
      "what is known.\n"
      "Example:\n  bipc explore --root 'Table(12)' --trace dead.txt --trace-format bip2 model.bip && bipc replay "
      "--published dead.txt --root 'Table(12)' model.bip");
}

void add_serve(CLI::App& app, ServeArguments& a) {
  CLI::App* command =
      app.add_subcommand("serve", "run a model in real time while clients post events, look at it and steer it");
  command->add_option("FILE", a.file, "a .bip or .bsys file")->required()->type_name("");
  command->add_option("--socket", a.socket, "listen at the Unix socket PATH, not to standard input")->type_name("PATH");
  command
      ->add_option_function<std::uint16_t>(
          "--port",
          [&a](const std::uint16_t& port) {
            a.port = port;
            a.has_port = true;
          },
          "listen at TCP port N of 127.0.0.1, not to standard input; 0: one that is free, told on standard error")
      ->check(is_number())
      ->type_name("N");
  command->add_flag("--paused", a.paused, "wait for `resume` or `step`");
  command->add_option("--seed", a.seed, "of the random choices (default 0)")->check(is_number())->type_name("N");
  add_choice(*command, "--policy", a.policy, kPolicies, "uniform|first|fair", "which of the possible steps is taken");
  add_choice(*command, "--backend", a.backend, kBackends, "jit|interp", "what executes guards, actions and transfers");
  add_cache_options(*command, a.compile.cache);
  command->add_flag("--asap", a.asap, "each step as soon as it is possible");
  command->add_option("--speed", a.speed, "F seconds of the model a second (default 1)")
      ->check(CLI::Range(1e-6, 1e6))
      ->type_name("F");
  add_real_time_priority(*command, a.real_time_priority);
  command
      ->add_option("--trace", a.trace_path, "write the steps to PATH; the file is complete when the process has ended")
      ->type_name("PATH");
  add_choice(*command, "--trace-format", a.trace_format, kServedFormats, "json|mcap|perfetto",
             "form of the trace; mcap for Foxglove, perfetto for ui.perfetto.dev");
  add_compile(*command, a.compile);
  command->footer(
      "Requests and answers are lines of JSON, see compiler/docs/serve.md; tools/serve_client.py speaks them.\n"
      "Example:\n  echo '{\"do\":\"hello\"}' | bipc serve model.bip");
}

void add_build(CLI::App& app, BuildArguments& a) {
  CLI::App* command = app.add_subcommand("build", "make a stand-alone program with the host's C++ compiler");
  command->add_option("FILE", a.file, "a .bip or .bsys file")->required()->type_name("");
  command->add_option("-o,--output", a.output, "the program to write")->required()->type_name("EXE");
  add_optimisation(*command, a.optimisation, true, "optimisation of the C++ compiler (by itself -O3)");
  add_compile(*command, a.compile);
  command->footer(
      "The compiler is $CXX, else c++, g++ or clang++.\nExample:\n  bipc build model.bip -o model && ./model --seed "
      "42");
}

void add_emit(CLI::App& app, EmitArguments& a) {
  CLI::App* command = app.add_subcommand("emit", "write the C++ of a model, or print a stage");
  command->add_option("FILE", a.file, "a .bip or .bsys file")->required()->type_name("");
  command->add_option("-o,--output", a.directory, "write model.cpp, CMakeLists.txt and the runtime's sources to DIR")
      ->type_name("DIR");
  add_optimisation(*command, a.optimisation, false, "for --emit=llvm and --emit=asm (default 2)");
  add_compile(*command, a.compile);
  command->footer(
      "Without -o the C++ (or what --emit names) goes to standard output.\nExample:\n  bipc emit model.bip -o "
      "generated");
}

void add_graph(CLI::App& app, GraphArguments& a) {
  CLI::App* command = app.add_subcommand("graph", "print a picture of a system for Graphviz, or the system as JSON");
  command->add_option("FILE", a.file, "a .bip or .bsys file")->required()->type_name("");
  add_choice(*command, "--format", a.format, kGraphFormats, "dot|json", "DOT is what Graphviz draws (default)");
  add_choice(*command, "--show", a.show, kShows, "all|structure|automata",
             "instances and connectors, the automaton of each atom type, or both (default)");
  add_compile(*command, a.compile);
  command->footer("Example:\n  bipc graph --show structure model.bip | dot -Tsvg -o model.svg");
}

void add_export(CLI::App& app, ExportArguments& a) {
  CLI::App* command =
      app.add_subcommand("export", "write a model for other tools: Promela for SPIN, PNML for Petri nets");
  command->add_option("FILE", a.file, "a .bip or .bsys file")->required()->type_name("");
  add_choice(*command, "--format", a.format, kExportFormats, "promela|pnml",
             "promela (default): int, bool and string data; pnml: no data that decides");
  command->add_option("-o,--output", a.output, "the file to write (default: standard output)")->type_name("FILE");
  command->add_flag_callback(
      "--disable-maximal-progress", [&a] { a.maximal_progress = false; },
      "smaller interactions may run although a larger one could");
  add_compile(*command, a.compile);
  command->footer(
      "Example:\n  bipc export --root 'Table(5)' model.bip -o m.pml && spin -a m.pml && cc -O2 -fwrapv -DSAFETY -o pan "
      "pan.c && ./pan");
}

void add_fmt(CLI::App& app, FmtArguments& a) {
  CLI::App* command = app.add_subcommand("fmt", "print models in house style");
  command->add_option("FILE", a.files, ".bip files")->required()->type_name("");
  CLI::Option* check =
      command->add_flag("--check", a.check, "print nothing but the names of files that would change; exit 1 if any");
  command->add_flag("-i,--in-place", a.in_place, "rewrite the files")->excludes(check);
  add_diagnostics(*command, a.compile);
  command->footer("Example:\n  bipc fmt -i model.bip");
}

void add_explain(CLI::App& app, Arguments& a) {
  CLI::App* command = app.add_subcommand("explain", "what a diagnostic code means, with a wrong and a right example");
  command->add_option("CODE", a.explain_code, "B1001, R0005 ...; without it all codes are listed")->type_name("");
  add_color(*command, a.explain_color);
  command->footer("Example:\n  bipc explain R0005");
}

void add_version(CLI::App& app) {
  app.add_subcommand("version", "version and back ends")->footer("Example:\n  bipc version");
}

// The published tools' call has no command word; its options stand on the program itself.
void add_published(CLI::App& app, PublishedArguments& a) {
  const char* group = "As the published tools are called";
  CLI::Option* package = app.add_option("-p", a.package, "package to check; its file is PACKAGE.bip in a folder of -I");
  package->type_name("PACKAGE")->group(group);
  app.add_option("-I", a.compile.folders, "where packages are (default: here)")
      ->allow_extra_args(false)
      ->type_name("DIR")
      ->needs(package)
      ->group(group);
  app.add_option("-d", a.compile.root, "root component, 'Root()'")
      ->type_name("TYPE(ARGS)")
      ->needs(package)
      ->group(group);
  app.add_option("--gencpp-output", a.cpp_output, "write C++ to DIR")->type_name("DIR")->needs(package)->group(group);
  app.add_flag("--Werr,--WError,--Werror", a.compile.warnings_are_errors, "warnings count as errors; -WError too")
      ->needs(package)
      ->group(group);
  app.add_option_function<std::string>(
         "-W", [&a](const std::string&) { a.compile.warnings_are_errors = true; }, "--Werr, written -WError or -WErr")
      ->needs(package)
      ->check(CLI::Validator(
          [](std::string& text) { return text == "Error" || text == "Err" ? "" : not_one_of(text, "Error, Err"); }, ""))
      ->group("");
  add_choice(app, "--diagnostics", a.compile.render.format, kFormats, "frame|short|json|sarif",
             "how errors and warnings look", group);
  // What steers the published C++ back end and its makefiles. `bipc emit` writes its own CMakeLists.txt.
  for (const char* name : {"--gencpp-cc-I", "--gencpp-cc-extra-src", "--gencpp-cc-extra-obj", "--gencpp-ld-L",
                           "--gencpp-ld-l", "--gencpp-optim", "--gencpp-set-optim-param", "--gencpp-disable-optim"}) {
    app.add_option_function<std::vector<std::string>>(
           name, [&a, name](const std::vector<std::string>&) { a.ignored.emplace_back(name); }, "")
        ->allow_extra_args(false)
        ->group("");
  }
  for (const char* name : {"--gencpp-follow-used-packages", "--gencpp-enable-marshalling", "--gencpp-no-serial"}) {
    app.add_flag_callback(
           name, [&a, name] { a.ignored.emplace_back(name); }, "")
        ->group("");
  }
}

void add_replay(CLI::App& app, ReplayArguments& a) {
  CLI::App* command = app.add_subcommand("replay", "follow a recorded run and compare each state");
  command->add_option("FILE", a.file, "a .bip or .bsys file")->required()->type_name("");
  CLI::Option* published = command
                               ->add_option("--published", a.published_trace,
                                            "the text that the published engine (or --trace-format=bip2) wrote")
                               ->type_name("TRACE");
  command
      ->add_option("--recorded", a.recorded_trace,
                   "a binary trace (`bipc run --trace-format=binary`); its steps are printed")
      ->type_name("TRACE")
      ->excludes(published);
  add_choice(*command, "--trace-format", a.format, kTraceFormats, "steps|json|bip2", "--recorded: form of the steps");
  command->add_flag("--silent", a.silent, "--recorded: no step lines");
  add_choice(*command, "--backend", a.backend, kBackends, "jit|interp", "what executes guards, actions and transfers");
  command->add_flag_callback(
      "--disable-maximal-progress", [&a] { a.maximal_progress = false; }, "the run had it too");
  add_compile(*command, a.compile);
  command->footer(
      "--published takes the choices of TRACE and compares the candidates of every state, in any order, with names, "
      "values and\n"
      "intervals.\n"
      "--recorded asks whether each step is a candidate where it is taken, and whether the last state is the recorded "
      "one.\n"
      "The first difference is told and ends with 1.\n"
      "Example:\n  bipc replay --published run.txt model.bip\n"
      "  bipc run --seed 1 --limit 100 --trace run.bin --trace-format binary model.bip && bipc replay --recorded "
      "run.bin model.bip");
}

void add_migrate(CLI::App& app, MigrateArguments& a) {
  CLI::App* command = app.add_subcommand("migrate", "print models with old spellings replaced by current ones");
  command->add_option("FILE", a.files, ".bip files")->required()->type_name("");
  command->add_flag("-i,--in-place", a.in_place, "rewrite the files");
  add_folders(*command, a.compile);
  add_diagnostics(*command, a.compile);
  command->footer(
      "Nothing else of a text changes: its layout and comments stay.\nExample:\n  bipc migrate -i model.bip");
}

// How modules become BIP.
void add_generation(CLI::App* command, GenomArguments& a) {
  command->add_option("-o,--output", a.output, "the .bip file to write (default: standard output)")->type_name("FILE");
  command
      ->add_option("--package", a.package,
                   "name of the package (default: of the output file, else of the first module)")
      ->type_name("NAME");
  command
      ->add_option("--yields", a.side_file,
                   "side file: what codels answer, which triggers wait, who reads which poster")
      ->type_name("FILE");
  command->add_option("--flavour", a.flavour, "codels answer freely (default), or are the C++ functions of their names")
      ->check(CLI::Validator(
          [](std::string& text) {
            return text == "verification" || text == "execution" ? "" : not_one_of(text, "verification|execution");
          },
          ""))
      ->type_name("verification|execution");
  auto* executive = command->add_flag(
      "--executive", a.executive,
      "execution flavour, and requests come from C++: executive_request, executive_answer, executive_reply");
  command
      ->add_flag("--served", a.served, "execution flavour in real time, and requests come from clients of `bipc serve`")
      ->excludes(executive);
  command->add_flag("--skeleton", a.skeleton,
                    "execution flavour, and empty codels in C++ beside the output; files that are there stay");
  command
      ->add_option("--instances", a.instances,
                   "activities a service may have at once (default 1); one more if it interrupts itself")
      ->check(CLI::Range(1, 16))
      ->type_name("N");
  command
      ->add_option(
          "--lock", a.lock,
          "what excludes codels: the module's lock, or the data that they use (default: as the generation has it)")
      ->check(CLI::Validator(
          [](std::string& text) { return text == "module" || text == "codel" ? "" : not_one_of(text, "module|codel"); },
          ""))
      ->type_name("module|codel");
  command->add_option("--tick", a.tick_ms, "length of a tick (default: the module's clock)")
      ->check(CLI::PositiveNumber)
      ->type_name("MS");
  command->add_option("--control-period", a.control_period, "ticks between two looks at the message box (default 1)")
      ->check(CLI::Range(1, 1000))
      ->type_name("TICKS");
  command->add_option("--poster-period", a.poster_period, "ticks between two steps of PosterAge (default 1)")
      ->check(CLI::Range(1, 1000))
      ->type_name("TICKS");
  command->add_option("--oldest", a.oldest, "where PosterAge stops (default 100)")
      ->check(CLI::Range(1, 1000000))
      ->type_name("N");
  command->add_option("-I", a.compile.folders, "where headers are; the file's own folder comes first")
      ->allow_extra_args(false)
      ->type_name("DIR");
  command->add_option("-D", a.defines, "define a macro")->allow_extra_args(false)->type_name("NAME[=VALUE]");
  add_diagnostics(*command, a.compile);
}

void add_genom(CLI::App& app, GenomArguments& a) {
  CLI::App* command = app.add_subcommand("genom", "translate descriptions of robot modules (GenoM 2 and 3) to BIP");
  command->add_option("FILE", a.files, ".gen files; all together are one functional level")->required()->type_name("");
  add_generation(command, a);
  command->footer("Example:\n  bipc genom demo.gen -o demo.bip && bipc verify demo.bip");
}

void add_rules(CLI::App& app, GenomArguments& a) {
  CLI::App* command =
      app.add_subcommand("rules", "translate rules over robot modules to a functional level that keeps them");
  command->add_option("FILE", a.files, "a .rules file; it names the modules")->required()->expected(1)->type_name("");
  command->add_flag("--prove", a.prove,
                    "first look for services that the rules never let in, and name the rules that do it");
  command->add_option("--timeout", a.timeout, "seconds for that (default 60)")
      ->check(CLI::Range(1, 100000000))
      ->type_name("S");
  add_generation(command, a);
  command->footer("Example:\n  bipc rules --prove rover.rules -o rover.bip && bipc verify rover.bip");
}

}  // namespace

void add_commands(CLI::App& app, Arguments& arguments) {
  add_published(app, arguments.published);
  add_check(app, arguments.check);
  add_run(app, arguments.run);
  add_verify(app, arguments.verify);
  add_explore(app, arguments.explore);
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
  add_version(app);
}

}  // namespace bip::driver
