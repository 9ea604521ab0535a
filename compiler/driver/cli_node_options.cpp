// The commands about runs on several hosts: `deploy` and `node`.
#include "compiler/driver/cli_options.hpp"
#include "compiler/driver/option_groups.hpp"

namespace bip::driver {

void add_deploy(CLI::App& app, DeployArguments& a) {
  CLI::App* command = app.add_subcommand(
      "deploy",
      "write a folder for each host of a run on several nodes: the model, keys, a start script, a systemd unit");
  add_model(*command, a.file);
  command
      ->add_option("--placement", a.placement_path,
                   "file that says which nodes there are, at which addresses, and what is at home where")
      ->required()
      ->type_name("PATH");
  command->add_option("-o,--output", a.output, "folder in which the nodes' folders are written")
      ->required()
      ->type_name("DIR");
  add_compile(*command, a.compile);
  command->footer("Example:\n  bipc deploy --placement robot.place -o robot model.bip\n  robot/start --limit 1000");
}

void add_node(CLI::App& app, NodeArguments& a) {
  CLI::App* command =
      app.add_subcommand("node", "run one node of a run on several hosts, from a folder of `bipc deploy`");
  command->add_option("DIR", a.folder, "the node's folder")->required()->type_name("");
  command
      ->add_option("--listen", a.listen,
                   "address and port to listen at, * for all addresses (default: those of the placement)")
      ->type_name("ADDRESS:PORT");
  add_seed(*command, a.run.seed, a.run.has_seed, "seed of the random choices (default: drawn at random and printed)");
  add_number(*command, "-l,--limit", a.run.limit, "stop the run after N steps (default: no limit)");
  add_choice(*command, "--policy", a.run.policy, kPolicies.names, kPolicies.shown,
             "how the next step is chosen among the candidates (default: uniform)");
  command->add_option("--trace", a.run.trace_path, "write a trace of the run to PATH (default format: json)")
      ->type_name("PATH");
  add_choice(*command, "--trace-format", a.run.format, kRunFormats.names, kRunFormats.shown,
             "format of the trace" + kRunFormats.help + " (default: steps, or json with --trace)");
  add_choice(*command, "--on-loss", a.run.on_loss, kOnLoss, "stop|go-on",
             "when a node is lost, stop the run or go on with what does not need it (default: stop)");
  add_duration(*command, "--lost-after", a.run.lost_after,
               "a node that gives no sign for TIME is lost; more than its longest action takes (default: 10s)");
  add_duration(
      *command, "--stall-after", a.stall_after,
      "when no step of this node has ended for TIME, print a warning and call the safe-stop function, if there is one "
      "(default: 1s if the model's C++ has one, else 0: never)");
  command
      ->add_option("--safe-stop", a.safe_stop,
                   "the C function of the model's C++ that stops the robot, `extern \"C\" void NAME(const char* why)` "
                   "(default: safe_stop, if there is one)")
      ->type_name("NAME");
  command->add_flag("-s,--silent", a.run.silent, "print no steps, only the seed and how the run ended");
  command->add_flag("--show-state", a.run.show_state, "print the places and data of each component at the end");
  command->add_flag("--stats", a.run.stats,
                    "print the number of steps, the duration, the messages and the CPU of the nodes at the end");
  add_optimisation(*command, a.optimisation, CompilerLevels::O0O2,
                   "optimisation level of this node's JIT; with 2 its own steps are compiled, also of a model without "
                   "data (default: 2 for at most 32 functions, else 0)");
  add_backend(*command, a.backend);
  add_cache_options(*command, a.compile.cache);
  add_no_cpp(*command, a.compile);
  add_diagnostics(*command, a.compile);
  command->footer(
      "The first node of the placement begins the run, and prints and writes its steps; options about the run are its "
      "own. Nodes start in any order and wait for each other.\n"
      "Exit code: 0 at the limit, at a final state or at a deadlock, 1 after a run-time error or a loss, 130 after "
      "Ctrl-C.\n"
      "Example:\n  bipc node robot/field --limit 1000 --trace run.trace");
}

}  // namespace bip::driver
