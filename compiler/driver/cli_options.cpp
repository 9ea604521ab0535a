// One function per command: its description, its options, its example. The commands that decide, count and draw are in
// cli_analysis_options.cpp, those about robot modules in cli_genom_options.cpp.
#include "compiler/driver/cli_options.hpp"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

#include "compiler/driver/option_groups.hpp"
#include "runtime/engine/event_file.hpp"

namespace bip::driver {

namespace {

void add_check(CLI::App& app, CheckArguments& a) {
  CLI::App* command = app.add_subcommand("check", "report all errors and warnings of models without running them");
  command->add_option("FILE", a.files, "model files (.bip or .bsys)")->required()->type_name("");
  command
      ->add_option("--placement", a.placement_path,
                   "print what a run distributed by this file (see distributed.md) would be: interactions over several "
                   "nodes, conflict sets, messages")
      ->type_name("PATH");
  command->add_flag("--json", a.json, "with --placement, print that as JSON: one line for each FILE")
      ->needs("--placement");
  command
      ->add_option(
          "--lesson", a.lesson,
          "judge FILE as the solution of the exercises of lesson N of the book, or of exercise K alone; exit code 3 "
          "if one is not solved")
      ->type_name("N[.K]");
  command->add_flag("--no-cpp", a.compile.refuses_cpp,
                    "with --lesson, which runs FILE: refuse models that call C++ (nothing that a model brings is "
                    "compiled or loaded)");
  add_compile(*command, a.compile);
  command->footer("Example:\n  bipc check --diagnostics=short model.bip\n  bipc check --lesson 1 kitchen.bip");
}

// What another engine would not look at is no part of what the person meant. Empty: there is no such option.
std::string option_of_other_engine(const CLI::App& run, rt::Engine engine) {
  const bool has_threads = engine == rt::Engine::Threads || engine == rt::Engine::Batch;
  if (!has_threads && run.count("--threads") != 0) return "--threads is of --engine=threads and --engine=batch";
  for (const char* option : {"--nodes", "--split-above", "--on-loss"}) {
    if (!rt::has_nodes(engine) && run.count(option) != 0)
      return fmt::format("{} is of --engine=distributed and --engine=simulated", option);
  }
  return {};
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
  add_number(*command, "-l,--limit", a.run.limit, "stop the run after N steps (default: no limit)");
  add_choice(*command, "--policy", a.run.policy, kPolicies.names, kPolicies.shown,
             "how the next step is chosen among the candidates (default: uniform)");
  add_backend(*command, a.backend);
  add_cache_options(*command, a.compile.cache);
  add_no_cpp(*command, a.compile);
  add_optimisation(*command, a.optimisation, CompilerLevels::O0O2,
                   "compile with this optimisation level before the first step (default: begin interpreted and change "
                   "to -O2 code during the run)");
  command->add_option("--trace", a.run.trace_path, "write a trace of the run to PATH (default format: json)")
      ->type_name("PATH");
  add_choice(*command, "--trace-format", a.run.format, kRunFormats.names, kRunFormats.shown,
             "format of the trace" + kRunFormats.help + " (default: steps, or json with --trace)");
  add_choice(
      *command, "--engine", a.run.engine, kEngines, "sequential|threads|batch|simulated|distributed",
      "threads executes long actions in parallel; batch executes independent short steps of a large system in "
      "parallel; distributed runs the components on several nodes, each a process; simulated does so in one process, "
      "with a simulated network (default: sequential)");
  command
      ->add_option("--threads", a.run.threads,
                   "worker threads of --engine=threads and --engine=batch (default: one per processor)")
      ->check(is_number(1, 256))
      ->type_name("N");
  command
      ->add_option("--nodes", a.run.nodes,
                   "number of nodes of --engine=distributed and --engine=simulated (default: 4)")
      ->check(is_number(1, rt::kMostNodes))
      ->type_name("N");
  command
      ->add_option("--placement", a.placement_path,
                   "place components on nodes as this file says (default: breadth first along connectors)")
      ->type_name("PATH")
      ->excludes("--nodes");
  command
      ->add_option("--split-above", a.split_above,
                   "on several nodes, give conflict sets of more than N interactions several coordinators, which lock "
                   "what they share (default: 1000, or as the placement says)")
      ->check(is_number(1, rt::kSplitNone))
      ->type_name("N");
  command
      ->add_option("--faults", a.run.network_faults,
                   "what goes wrong in the simulated network, for example 'cut 1-2 3s..5s, crash 3 5s, slow 2 x10, "
                   "lose 5%, double 5%'")
      ->type_name("FAULTS");
  add_choice(*command, "--on-loss", a.run.on_loss, kOnLoss, "stop|go-on",
             "when a node is lost, stop the run or go on with what does not need it (default: stop)");
  add_duration(
      *command, "--checkpoint", a.run.checkpoint_every,
      "with --engine=distributed or --engine=simulated, write a checkpoint every TIME, from which --resume goes "
      "on; SIGUSR1 asks for one at once");
  command
      ->add_option("--checkpoint-file", a.run.checkpoint_path,
                   "write checkpoints to PATH, each in place of the one before (default with --checkpoint: "
                   "run.checkpoint)")
      ->type_name("PATH");
  command
      ->add_option("--resume", a.run.resume_path,
                   "go on from the checkpoint in PATH, with any number of nodes and any placement")
      ->type_name("PATH");
  command->final_callback([command, &a] { a.misplaced = option_of_other_engine(*command, a.run.engine); });
  command->add_flag("-a,--asap", a.run.asap,
                    "take each step at the earliest instant at which it is possible (for models with clocks)");
  command->add_flag_callback(
      "--real-time", [&a] { a.run.speed = a.run.speed > 0 ? a.run.speed : 1; },
      "run in real time (default: logical time, which passes without waiting)");
  command->add_option("--speed", a.run.speed, "run in real time, with F seconds of model time per second")
      ->check(is_real(1e-6, 1e6))
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

void add_step(CLI::App& app, StepArguments& a) {
  CLI::App* command = app.add_subcommand(
      "step", "step through a model, forward and back, with breakpoints: commands are read from the terminal");
  add_model(*command, a.file);
  CLI::Option* trace = command->add_option("--trace", a.trace_path,
                                           "begin at the end of the run in TRACE: a trace in JSON lines, binary, "
                                           "bip2, MCAP or Perfetto, or a record of `bipc run --record`");
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

// Those that a served program has as well.
void add_serve_options(CLI::App& command, serve::ServeSettings& settings) {
  for (const serve::ServeOption& row : serve::serve_options()) {
    if (row.value.empty()) {
      command.add_flag_callback(
          row.name, [&row, &settings] { (void)row.read("", settings); }, row.help);
      continue;
    }
    CLI::Option* const option = command.add_option_function<std::string>(
        row.name, [&row, &settings](const std::string& text) { (void)row.read(text, settings); }, row.help);
    if (row.help.empty()) option->group("");
    option
        ->check(CLI::Validator(
            [&row](std::string& text) {
              serve::ServeSettings tried;
              return row.read(text, tried);
            },
            ""))
        ->type_name(row.value);
  }
}

void add_serve(CLI::App& app, ServeArguments& a) {
  CLI::App* command =
      app.add_subcommand("serve", "run a model in real time while clients post events, observe it and control it");
  add_model(*command, a.file);
  add_serve_options(*command, a);
  add_backend(*command, a.backend);
  add_cache_options(*command, a.compile.cache);
  add_no_cpp(*command, a.compile);
  add_compile(*command, a.compile);
  command->footer(
      "Requests and answers are lines of JSON, see compiler/docs/serve.md; tools/serve_client.py is an example of a "
      "client. `bipc build --serve` makes a program that serves a model without compiling it.\n"
      "Example:\n  echo '{\"do\":\"hello\"}' | bipc serve model.bip");
}

void add_build(CLI::App& app, BuildArguments& a) {
  CLI::App* command = app.add_subcommand("build", "build a stand-alone program with the host's C++ compiler");
  add_model(*command, a.file);
  command->add_option("-o,--output", a.output, "program to write")->required()->type_name("EXE");
  add_optimisation(*command, a.optimisation, CompilerLevels::O0O1O2,
                   "optimisation level of the C++ compiler (default: 3)");
  command->add_flag("--serve", a.serves,
                    "build a program that serves the model, as `bipc serve` does; it starts without compiling");
  add_compile(*command, a.compile);
  add_no_cpp(*command, a.compile);
  command->footer(
      "The compiler is $CXX, else c++, g++ or clang++.\nExample:\n  bipc build model.bip -o model && ./model --seed "
      "42");
}

void add_emit(CLI::App& app, EmitArguments& a) {
  CLI::App* command =
      app.add_subcommand("emit", "write the C++ code of a model, or print the product of a compiler stage");
  add_model(*command, a.file);
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
  // What is linked into the emitted program. CLI11 does not name hidden options in its messages, but their types.
  const auto add_value = [&app](const char* name, auto take) {
    app.add_option_function<std::vector<std::string>>(
           name,
           [take](const std::vector<std::string>& values) {
             for (const std::string& value : values) take(value);
           },
           "")
        ->allow_extra_args(false)
        ->type_name(fmt::format("value of `{}`", name))
        ->group("");
  };
  for (const auto& [name, list] :
       {std::pair("--gencpp-cc-extra-src", &a.sources), std::pair("--gencpp-cc-extra-obj", &a.objects),
        std::pair("--gencpp-ld-extra-obj", &a.objects), std::pair("--gencpp-ld-L", &a.link_folders),
        std::pair("--gencpp-ld-l", &a.libraries)}) {
    add_value(name, [list = list](const std::string& value) { list->push_back(value); });
  }
  // What steers the published C++ back end and its makefiles. `bipc emit` writes its own CMakeLists.txt.
  for (const char* name : {"--gencpp-cc-extra-opt", "--gencpp-optim", "--gencpp-set-optim-param"})
    add_value(name, [&a, name](const std::string&) { a.ignored.emplace_back(name); });
  for (const char* name : {"--gencpp-follow-used-packages", "--gencpp-enable-bip-debug", "--gencpp-enable-marshalling",
                           "--gencpp-no-serial"}) {
    app.add_flag_callback(
           name, [&a, name] { a.ignored.emplace_back(name); }, "")
        ->group("");
  }
  // Of one optimisation, or of all.
  for (const char* name : {"--gencpp-enable-optim", "--gencpp-disable-optim"}) {
    app.add_option_function<std::vector<std::string>>(
           name, [&a, name](const std::vector<std::string>&) { a.ignored.emplace_back(name); }, "")
        ->expected(0, 1)
        ->group("");
  }
}

void add_replay(CLI::App& app, ReplayArguments& a) {
  CLI::App* command =
      app.add_subcommand("replay", "follow a recorded run and compare each of its states with the model");
  add_model(*command, a.file);
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
  command->add_option("--resume", a.resume_path, "with --recorded, the checkpoint from which the recorded run went on")
      ->type_name("PATH");
  add_choice(*command, "--trace-format", a.format, kTextFormats.names, kTextFormats.shown,
             "with --recorded, format of the printed steps (default: steps)");
  command->add_flag("--silent", a.silent, "with --recorded, print no steps");
  add_backend(*command, a.backend);
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
  CLI::App* command =
      app.add_subcommand("migrate", "print models with obsolete spellings replaced by current ones, or BIP1 as BIP2");
  command->add_option("FILE", a.files, "model files (.bip)")->required()->type_name("");
  CLI::Option* in_place =
      command->add_flag("-i,--in-place", a.in_place, "rewrite the files in place instead of printing them");
  command->add_option("-o,--output", a.output, "file to write instead of printing (of one FILE)")
      ->type_name("PATH")
      ->excludes(in_place);
  add_folders(*command, a.compile);
  add_diagnostics(*command, a.compile);
  command->footer(
      "Layout and comments are kept. A file that begins with `model NAME` is BIP1: it is written anew in BIP2, and its "
      "C "
      "code, where BIP2 has no words for it, in a .hpp and a .cpp file beside the output.\n"
      "Example:\n  bipc migrate -i model.bip\n  bipc migrate bip1.bip -o model.bip");
}

// In the order of the help.
constexpr struct {
  std::string_view name;
  void (*add)(CLI::App& app, Arguments& arguments);
} kCommands[] = {
    {"check", [](CLI::App& app, Arguments& arguments) { add_check(app, arguments.check); }},
    {"run", [](CLI::App& app, Arguments& arguments) { add_run(app, arguments.run); }},
    {"verify", [](CLI::App& app, Arguments& arguments) { add_verify(app, arguments.verify); }},
    {"explore", [](CLI::App& app, Arguments& arguments) { add_explore(app, arguments.explore); }},
    {"simulate", [](CLI::App& app, Arguments& arguments) { add_simulate(app, arguments.simulate); }},
    {"step", [](CLI::App& app, Arguments& arguments) { add_step(app, arguments.step); }},
    {"view", [](CLI::App& app, Arguments& arguments) { add_view(app, arguments.view); }},
    {"trace", [](CLI::App& app, Arguments& arguments) { add_trace(app, arguments.trace); }},
    {"dap", [](CLI::App& app, Arguments&) { add_dap(app); }},
    {"serve", [](CLI::App& app, Arguments& arguments) { add_serve(app, arguments.serve); }},
    {"deploy", [](CLI::App& app, Arguments& arguments) { add_deploy(app, arguments.deploy); }},
    {"node", [](CLI::App& app, Arguments& arguments) { add_node(app, arguments.node); }},
    {"build", [](CLI::App& app, Arguments& arguments) { add_build(app, arguments.build); }},
    {"emit", [](CLI::App& app, Arguments& arguments) { add_emit(app, arguments.emit); }},
    {"graph", [](CLI::App& app, Arguments& arguments) { add_graph(app, arguments.graph); }},
    {"export", [](CLI::App& app, Arguments& arguments) { add_export(app, arguments.exported); }},
    {"replay", [](CLI::App& app, Arguments& arguments) { add_replay(app, arguments.replay); }},
    {"fmt", [](CLI::App& app, Arguments& arguments) { add_fmt(app, arguments.fmt); }},
    {"migrate", [](CLI::App& app, Arguments& arguments) { add_migrate(app, arguments.migrate); }},
    {"genom", [](CLI::App& app, Arguments& arguments) { add_genom(app, arguments.genom); }},
    {"rules", [](CLI::App& app, Arguments& arguments) { add_rules(app, arguments.rules); }},
    {"ros1", [](CLI::App& app, Arguments& arguments) { add_ros1(app, arguments.ros1); }},
    {"ros2", [](CLI::App& app, Arguments& arguments) { add_ros2(app, arguments.ros2); }},
    {"explain", [](CLI::App& app, Arguments& arguments) { add_explain(app, arguments); }},
    {"completion", [](CLI::App& app, Arguments& arguments) { add_completion(app, arguments.shell); }},
    {"version", [](CLI::App& app, Arguments& arguments) { add_version(app, arguments.version); }},
};

}  // namespace

void add_commands(CLI::App& app, Arguments& arguments, std::string_view first) {
  // Completion lists all of them.
  const auto named = std::find_if(std::begin(kCommands), std::end(kCommands),
                                  [first](const auto& row) { return row.name == first && first != "completion"; });
  if (named != std::end(kCommands)) return named->add(app, arguments);
  add_published(app, arguments.published);
  for (const auto& row : kCommands) row.add(app, arguments);
}

}  // namespace bip::driver
