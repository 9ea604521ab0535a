// The options of the commands that decide, count and draw: one function per command.
#include <cstdint>
#include <limits>

#include "compiler/base/log.hpp"
#include "compiler/driver/option_groups.hpp"

namespace bip::driver {

namespace {

// Without a property a command has a default; a script whose variable is empty did not ask for it.
CLI::Validator is_no_empty_property() {
  return CLI::Validator(
      [](std::string& text) {
        const bool is_empty = text.find_first_not_of(" \t\r\n") == std::string::npos;
        return is_empty ? std::string("the property is empty; without the option the default is asked") : std::string();
      },
      "");
}

void add_fair(CLI::App& command, std::string& fair) {
  command
      .add_option(
          "--fair", fair,
          "runs that count for a property of runs: all (none, default), those in which whatever stays possible happens "
          "(weak), or whatever is possible again and again (strong); for each interaction, for each component "
          "(:atoms), "
          "or for a connector, a port or a component with that name, `[*]` in it for each position of an array")
      ->check(CLI::Validator([](std::string& text) { return verify::problem_of_fairness(text); }, ""))
      ->type_name("none|weak|strong[:atoms|:NAME],...");
}

}  // namespace

void add_verify(CLI::App& app, VerifyArguments& a) {
  CLI::App* command = app.add_subcommand("verify", "prove that a model never deadlocks, or show a run that does");
  add_model(*command, a.file);
  command
      ->add_option(
          "--property", a.property,
          "property to decide: deadlock, errors, the name of a property of the model, 'never EXPR', 'always EXPR', or "
          "of runs: 'eventually EXPR', 'EXPR leads to EXPR', 'EXPR until EXPR' …, or of what is possible: "
          "'always possibly EXPR' … (default: deadlock, and each property that the model states)")
      ->check(is_no_empty_property())
      ->type_name("WHAT");
  command
      ->add_option("--properties", a.properties_path,
                   "read more properties of the model from PATH: `property NAME { … }` as in a compound")
      ->type_name("PATH");
  add_fair(*command, a.fair);
  add_number(*command, "--timeout", a.timeout,
             "give up after SECONDS of processor time, of all threads together (default: 60)", "SECONDS");
  add_number(*command, "--wall-timeout", a.wall_timeout,
             "give up after SECONDS of wall-clock time too (default: no limit)", "SECONDS");
  add_number(*command, "--memory", a.megabytes,
             "memory limit for the states that a search stores, and for the circuit (default: 2048)", "MB");
  command
      ->add_option("--certificate", a.certificate,
                   "write a certificate of the proof to PATH, for the checker certcheck")
      ->type_name("PATH");
  command
      ->add_flag("--partial", a.partial,
                 "decide whether some components can wait forever while others move (local deadlock)")
      ->excludes("--property")
      ->excludes("--fair");
  command
      ->add_option("--for-all", a.for_all,
                   "decide whether a compound with one parameter, `int N`, is free of deadlocks for every value of it, "
                   "from the first that compiles or from NUMBER on; --root TYPE chooses the compound")
      ->excludes("--property")
      ->excludes("--properties")
      ->excludes("--partial")
      ->excludes("--fair")
      ->type_name("'N [>= NUMBER]'");
  command->add_flag("--all-steps", a.all_steps,
                    "show also the steps that the run which violates the property does not need");
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
  command->add_flag("--stats", a.stats,
                    "print the processor time and how much was reused from earlier proofs; without time, and but for "
                    "properties of runs, also the engine that decided");
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
      "parts,\n"
      "previously, once, historically and since for what has been, and happens connector, happens a.port for the step "
      "that is taken.\n"
      "Over an array: forall i in a: a[i]@PLACE, exists i in a: EXPR, at most 1 i in a: EXPR, at least, exactly.\n"
      "Possibly before a word asks for some run from a state: possibly EXPR, always possibly EXPR, possibly always "
      "EXPR.\n"
      "Under at the end says its fairness, in the place of --fair: EXPR leads to EXPR under weak:c, strong:a.p.\n"
      "With time: eventually F, always eventually F, E leads to F; and E leads to F within 50 ms, eventually F within "
      "2 s.\n"
      "Exit code: 0 the property holds, 3 it is violated (a run is printed), 4 unknown. Ctrl-C prints what is known "
      "and ends with 4.\n"
      "Example:\n  bipc verify --root 'Table(1000)' --certificate table.cert model.bip\n"
      "  bipc verify --property 'never phil[0]@EATS && phil[1]@EATS' model.bip\n"
      "  bipc verify --property 'phil[0]@HUNGRY leads to phil[0]@EATS' --fair=weak model.bip\n"
      "  bipc verify --property 'always eventually phil[0]@EATS' --fair=weak,strong:eat[0] model.bip\n"
      "  bipc verify --property errors model.bip\n"
      "  bipc verify --for-all n --root Table model.bip");
}

void add_explore(CLI::App& app, ExploreArguments& a) {
  CLI::App* command =
      app.add_subcommand("explore", "visit all reachable states: count them, find deadlocks and run-time errors");
  add_model(*command, a.file);
  add_choice(*command, "--reduce", a.explore.reduction, kReductions, "none|por|symmetry",
             "visit fewer states: por (partial order reduction) keeps all deadlocks, symmetry merges states that "
             "differ by a permutation of equal components (default: none)");
  add_number(*command, "--threads", a.threads, "number of worker threads (default: one per processor)");
  add_number(*command, "--memory", a.megabytes,
             "memory limit of the search (default: three quarters of the free memory)", "MB");
  add_number(*command, "--timeout", a.seconds, "stop after SECONDS of wall-clock time (default: no limit)", "SECONDS");
  add_number(*command, "--limit", a.explore.limit, "stop after N states (default: no limit)");
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
  add_backend(*command, a.backend);
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
  add_model(*command, a.file);
  command
      ->add_option_function<std::uint64_t>(
          "--runs", [&a](std::uint64_t runs) { a.simulate.runs = runs, a.has_runs = true; },
          "number of runs (default: 1000)")
      ->check(is_number())
      ->type_name("N");
  command
      ->add_option("--within", a.within, "make so many runs that a probability is known within E (instead of --runs)")
      ->check(is_real(0.0001, 0.5))
      ->type_name("E");
  command->add_option("--confidence", a.confidence, "probability that an interval contains the truth (default: 0.95)")
      ->check(is_real(0.5, 0.999999))
      ->type_name("P");
  add_seed(*command, a.simulate.seed, a.has_seed,
           "seed of the first run; each later run has the next number (default: drawn at random and printed)");
  command
      ->add_option_function<std::uint64_t>(
          "-l,--limit", [&a](std::uint64_t steps) { a.simulate.limit = steps, a.has_limit = true; },
          "steps of a run (default: 1000; of splitting: 1000000)")
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
  command
      ->add_option("--query", a.queries,
                   "answer a question: P=? [ PATH ], P>=0.9 [ PATH ], P<=0.1 [ PATH ], E=? [ OBSERVER ]; a PATH is F "
                   "EXPR, G EXPR or EXPR U EXPR, with a bound in steps or time as in F<=100 EXPR, F<=5s EXPR")
      ->type_name("QUERY")
      ->allow_extra_args(false);
  command->add_flag("--exact", a.exact,
                    "answer queries on the Markov chain of all reachable states instead of by runs; for models without "
                    "time and C++");
  command->add_option("--alpha", a.test.alpha, "probability that P>=S is denied though it holds (default: 0.05)")
      ->check(is_real(1e-9, 0.49))
      ->type_name("P");
  command
      ->add_option("--beta", a.test.beta, "probability that P>=S is affirmed though it does not hold (default: 0.05)")
      ->check(is_real(1e-9, 0.49))
      ->type_name("P");
  command
      ->add_option("--delta", a.test.delta,
                   "distance from S within which a test of P>=S may answer either way (default: 0.01)")
      ->check(is_real(1e-9, 0.49))
      ->type_name("D");
  command
      ->add_option("--importance", a.importance,
                   "estimate the probability of a rare event by splitting: the number EXPR grows on the way to it")
      ->type_name("EXPR");
  command->add_option("--levels", a.levels, "levels of EXPR at which runs are split (default: found by trial runs)")
      ->delimiter(',')
      ->type_name("X,Y,...");
  add_number(*command, "--effort", a.effort, "runs at each level of splitting (default: 1000)");
  add_number(*command, "--replications", a.replications, "independent estimates by splitting (default: 32)");
  command->add_option("--stop", a.stop, "end a run at the first state in which the condition EXPR holds")
      ->type_name("EXPR");
  add_choice(*command, "--policy", a.simulate.policy, kPolicies.names, kPolicies.shown,
             "how the next step is chosen among the candidates (default: uniform)");
  command->add_flag("-a,--asap", a.simulate.asap,
                    "with time, take each step at the first instant at which one is possible");
  add_number(*command, "--threads", a.threads, "number of worker threads (default: one per processor)");
  command->add_flag("--histogram", a.shows_histogram, "print how often each value was observed, in 20 bins");
  command->add_flag("--json", a.json, "print the result as JSON");
  command->add_option("--csv", a.csv_path, "write a row for each run to PATH")->type_name("PATH");
  add_backend(*command, a.backend);
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
      "Exit code: 0, or 1 if a run ended with a run-time error, 3 if the answer to a P>=S is no, 4 if it stays open, "
      "130 "
      "after Ctrl-C.\n"
      "Example:\n  bipc simulate --runs 10000 --limit 100 --observe 'count eat[0]' --observe 'reaches "
      "phil[0]@EATS' model.bip");
}

void add_export(CLI::App& app, ExportArguments& a) {
  CLI::App* command = app.add_subcommand("export",
                                         "write a model for other tools: Promela for SPIN, PNML for Petri nets, AIGER "
                                         "for model checkers of circuits, PRISM "
                                         "for those of probabilities");
  add_model(*command, a.file);
  add_choice(
      *command, "--format", a.format, kExportFormats, "promela|pnml|aiger|net|prism",
      "output format: promela (default; int, bool and string data), pnml (models without guards over data), aiger "
      "(the prover's transition system as an and-inverter graph, with one output: bad), net (the prover's net as a "
      "DOT graph) or prism (the Markov chain of the runs under the policy uniform, for PRISM and Storm)");
  command
      ->add_option(
          "--property", a.property,
          "property that the output asks, as for verify: in the format promela one of states or runs, in aiger one of "
          "states (default: deadlock)")
      ->check(is_no_empty_property())
      ->type_name("PROPERTY");
  add_fair(*command, a.fair);
  command
      ->add_option("--max-size", a.max_size,
                   "refuse a Petri net (pnml) of more than N transitions (default: 1000000), or a Markov chain (prism) "
                   "of more than N states (default: 100000)")
      ->check(is_number(1, std::numeric_limits<std::uint32_t>::max()))
      ->type_name("N");
  command->add_option("-o,--output", a.output, "output file (default: standard output)")->type_name("FILE");
  command->add_flag_callback(
      "--disable-maximal-progress", [&a] { a.maximal_progress = false; },
      "disable maximal progress: an interaction may fire although a larger one of its connector is enabled");
  add_compile(*command, a.compile);
  command->footer(
      "Example:\n  bipc export --root 'Table(5)' model.bip -o m.pml && spin -a m.pml && cc -O2 -fwrapv -DSAFETY -o pan "
      "pan.c && ./pan");
}

namespace {

// What a picture shows of a large system.
void add_folding(CLI::App& command, graph::PictureOptions& picture) {
  add_number(command, "--fold", picture.fold, "draw arrays of more than N components as one box (default: 8)");
  add_number(command, "--depth", picture.depth,
             "draw compounds N levels below the root as closed boxes (default: none)");
  add_number(command, "--bundle", picture.bundle,
             "in compounds with more than N connectors draw those that join the same closed boxes as one line "
             "(default: 60)");
  command
      .add_option("--open", picture.open,
                  "draw the array or compound PATH open all the same, `phil` or `line.before`; may be repeated")
      ->allow_extra_args(false)
      ->type_name("PATH");
}

}  // namespace

void add_graph(CLI::App& app, GraphArguments& a) {
  CLI::App* command =
      app.add_subcommand("graph", "draw a system: components, ports, connectors, automata; or print it as DOT or JSON");
  command
      ->add_option("FILE", a.files,
                   "model file (.bip or .bsys); with --show modules module descriptions (.gen), or one rules file "
                   "(.rules) with the modules that it names")
      ->required()
      ->type_name("");
  command->add_option("-o,--output", a.output, "write the picture to FILE; its suffix says the format")
      ->type_name("FILE");
  add_choice(*command, "--format", a.format, kGraphFormats, "svg|png|html|dot|json",
             "output format: svg (a picture), png (the same, by the program rsvg-convert), html (a page to look around "
             "in), dot for Graphviz (default without -o) or json");
  add_choice(*command, "--show", a.shown, kShown, "all|structure|automata|modules",
             "what to show: instances and connectors (structure), the automaton of each atom type (automata), or both "
             "(all, default); of robot modules their services, tasks and posters, who reads them, and the rules "
             "between them (modules)");
  command
      ->add_option("--yields", a.side_file,
                   "with --show modules, file with additional facts, as for `bipc genom`: who reads which poster")
      ->type_name("FILE");
  command->add_option("-D", a.defines, "with --show modules, define a preprocessor macro; may be repeated")
      ->allow_extra_args(false)
      ->type_name("NAME[=VALUE]");
  add_folding(*command, a.picture);
  add_compile(*command, a.compile);
  command->footer(
      "Example:\n  bipc graph model.bip -o model.svg\n  bipc graph --show modules rover.rules -o rover.svg");
}

void add_view(CLI::App& app, ViewArguments& a) {
  CLI::App* command = app.add_subcommand("view",
                                         "write a page that shows a model and a run of it, step by step, in a browser: "
                                         "one file without requests; or serve "
                                         "a live page");
  add_model(*command, a.file);
  CLI::Option* output =
      command->add_option("-o,--output", a.output, "page to write (default: the model's name with .html)");
  output->type_name("PAGE");
  command
      ->add_option(
          "--certificate", a.certificate,
          "show the invariants in CERT, which `bipc verify --certificate` wrote, on the places that they speak "
          "of")
      ->type_name("CERT");
  CLI::Option* port = command->add_option_function<std::uint16_t>(
      "--port",
      [&a](const std::uint16_t& number) {
        a.port = number;
        a.is_live = true;
      },
      "write no page but serve a live one at port N of 127.0.0.1 (0: a free one), in which a person chooses the steps; "
      "prints its address, which holds a secret token");
  port->check(is_number())->excludes(output)->type_name("N");
  CLI::Option* attach = command->add_option(
      "--attach", a.attached_to,
      "serve a live page of the model that `bipc serve` runs at WHERE: SOCKET, or PORT:TOKEN of this machine, or PORT "
      "with the token in $BIPC_TOKEN; MODEL is the served one");
  attach->excludes(output)->type_name("WHERE");
  CLI::Option* trace =
      command->add_option("--trace", a.trace_path,
                          "show the run in TRACE: a trace in JSON lines, binary, bip2, MCAP or Perfetto, a "
                          "counterexample of `bipc verify --trace`, or a record of `bipc run --record`");
  trace->excludes(attach)->type_name("TRACE");
  command->add_option("--steps", a.steps, "show a run of at most N steps (default: 200)")
      ->check(is_number())
      ->excludes(trace)
      ->excludes(attach)
      ->excludes(port)
      ->type_name("N");
  add_session(*command, a, trace);
  add_folding(*command, a.picture);
  add_cache_options(*command, a.compile.cache);
  add_no_cpp(*command, a.compile);
  add_compile(*command, a.compile);
  command->footer(
      "Example:\n  bipc verify --trace dead.json model.bip; bipc view --trace dead.json model.bip -o model.html");
}

}  // namespace bip::driver
