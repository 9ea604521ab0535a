// The options of the commands that translate robot modules: `genom` and `rules`.
#include <algorithm>
#include <cctype>

#include "compiler/driver/cli_options.hpp"
#include "compiler/driver/option_groups.hpp"

namespace bip::driver {

namespace {

// How modules become BIP.
void add_generation(CLI::App* command, GenomArguments& a) {
  command->add_option("-o,--output", a.output, "output file, a .bip file (default: standard output)")
      ->type_name("FILE");
  command
      ->add_option("--package", a.package,
                   "name of the package (default: name of the output file, or of the first module)")
      ->type_name("NAME");
  command
      ->add_option("--yields", a.side_file,
                   "file with additional facts: results of codels, waiting triggers, readers of posters")
      ->type_name("FILE");
  command
      ->add_option("--flavour", a.flavour,
                   "model of codels: any result is possible (verification, default), or C++ functions of the same "
                   "names are called (execution)")
      ->check(CLI::Validator(
          [](std::string& text) {
            return text == "verification" || text == "execution" ? "" : not_one_of(text, "verification|execution");
          },
          ""))
      ->type_name("verification|execution");
  auto* executive = command->add_flag("--executive", a.executive,
                                      "use the execution flavour and take requests from the C++ functions "
                                      "executive_request, executive_answer and executive_reply");
  auto* served = command
                     ->add_flag("--served", a.served,
                                "use the execution flavour in real time and take requests from clients of `bipc serve`")
                     ->excludes(executive);
  command
      ->add_flag("--skeleton", a.skeleton,
                 "use the execution flavour and write empty C++ codels and their header beside the output; existing "
                 "codels are kept")
      ->excludes(command
                     ->add_option("--codels", a.codels,
                                  "C or C++ file of codels as genom3 calls them (GenoM 3); headers with genom3's "
                                  "names and what calls the codels are written beside the output; may be repeated")
                     ->allow_extra_args(false)
                     ->excludes(executive)
                     ->type_name("FILE"));
  auto* processes = command->add_flag(
      "--processes", a.processes,
      "use the execution flavour and run the codels of each module in a process of its own, which is started again "
      "when it has died");
  command
      ->add_flag(
          "--task-threads", a.task_threads,
          "run the codels of activities and tasks in threads: a slow one holds up its own task, and nothing else")
      ->needs(served);
  add_duration(*command, "--kill-after", a.kill_after,
               "end the process of a codel that takes so long, or so much longer than its budget (default: 0: never)")
      ->needs(processes);
  command
      ->add_option("--module-memory", a.module_memory,
                   "megabytes that the process of each module may take beside those at its beginning (default: no "
                   "limit)")
      ->check(is_number(1, 1000000))
      ->needs(processes)
      ->type_name("MB");
  command
      ->add_option("--instances", a.instances,
                   "activities of a service that may run at the same time (default: 1; one more for a service that "
                   "interrupts itself)")
      ->check(is_number(1, 16))
      ->type_name("N");
  command
      ->add_option("--lock", a.lock,
                   "mutual exclusion of codels: one lock per module, or by the data that each codel uses (default: as "
                   "the GenoM version prescribes)")
      ->check(CLI::Validator(
          [](std::string& text) { return text == "module" || text == "codel" ? "" : not_one_of(text, "module|codel"); },
          ""))
      ->type_name("module|codel");
  command
      ->add_option(
          "--as-in-the-paper", a.design,
          "how modules wait for what they interrupt, and how their timers tick, in Section V of the paper: the "
          "first design, which deadlocks, or the repaired one")
      ->check(CLI::Validator(
          [](std::string& text) {
            return text == "first" || text == "repaired" ? "" : not_one_of(text, "first|repaired");
          },
          ""))
      ->type_name("first|repaired");
  command->add_option("--tick", a.tick_ms, "length of a tick in milliseconds (default: clock period of the module)")
      ->check(is_real(1e-6, 1e6))
      ->type_name("MS");
  command->add_option("--control-period", a.control_period, "ticks between two reads of the message box (default: 1)")
      ->check(is_number(1, 1000))
      ->type_name("TICKS");
  command->add_option("--poster-period", a.poster_period, "ticks between two increments of PosterAge (default: 1)")
      ->check(is_number(1, 1000))
      ->type_name("TICKS");
  command->add_option("--oldest", a.oldest, "greatest value of PosterAge (default: 100)")
      ->check(is_number(1, 1000000))
      ->type_name("N");
  command->add_option("-I", a.compile.folders, "search DIR for headers, after the folder of the file; may be repeated")
      ->allow_extra_args(false)
      ->type_name("DIR");
  command->add_option("-D", a.defines, "define a preprocessor macro; may be repeated")
      ->allow_extra_args(false)
      ->type_name("NAME[=VALUE]");
  add_diagnostics(*command, a.compile);
}

}  // namespace

void add_genom(CLI::App& app, GenomArguments& a) {
  CLI::App* command = app.add_subcommand("genom", "translate descriptions of robot modules (GenoM 2 and 3) to BIP");
  command->add_option("FILE", a.files, "module descriptions (.gen); all files together form one functional level")
      ->required()
      ->type_name("");
  add_generation(command, a);
  command->footer("Example:\n  bipc genom demo.gen -o demo.bip && bipc verify demo.bip");
}

void add_rules(CLI::App& app, GenomArguments& a) {
  CLI::App* command =
      app.add_subcommand("rules", "translate safety rules over robot modules to a functional level that enforces them");
  command->add_option("FILE", a.files, "rules file (.rules), which names the module descriptions")
      ->required()
      ->expected(1)
      ->type_name("");
  command->add_flag("--prove", a.prove,
                    "first search for services that the rules never admit, and name the rules responsible");
  command->add_flag(
      "--left-out", a.lists_left_out,
      "write no BIP but list the services of which a rule says nothing, and which interrupt its services, "
      "are interrupted by them, or write the same poster");
  command->add_flag("--reduced", a.reduced,
                    "write the modules reduced to what the rules are about, of which --prove asks");
  command->add_option("--timeout", a.timeout, "time limit of --prove in seconds of processor time (default: 60)")
      ->check(is_number(1, 100000000))
      ->type_name("S");
  add_generation(command, a);
  command->footer("Example:\n  bipc rules --prove rover.rules -o rover.bip && bipc verify rover.bip");
}

namespace {

// What both bridges have; `ros` is "ROS 1" or "ROS 2".
void add_level(CLI::App& command, BridgeArguments& a, const std::string& ros) {
  command
      .add_option("FILE", a.level.files,
                  "module descriptions (.gen), or one rules file (.rules) with the modules that it names")
      ->required()
      ->type_name("");
  command
      .add_option("--serve", a.serve,
                  "run the bridge to the `bipc serve` at WHERE: SOCKET, or PORT:TOKEN, or PORT with the token in "
                  "$BIPC_TOKEN")
      ->type_name("WHERE");
  command
      .add_option("--interfaces", a.interfaces,
                  "write the package of " + ros + " with the types of actions and topics to the folder DIR")
      ->type_name("DIR");
  command
      .add_option("--package", a.level.package,
                  "name of that package (default: name of the rules or of the first module, with `_msgs`)")
      ->type_name("NAME");
  command.add_option("--module", a.modules, "offer services and posters of this module only; may be repeated")
      ->allow_extra_args(false)
      ->type_name("NAME");
  command.add_option("--namespace", a.name_space, "put NAME/ in front of the names of actions and topics")
      ->check(CLI::Validator(
          [](std::string& text) {
            const bool is_name =
                !text.empty() && std::isdigit(static_cast<unsigned char>(text[0])) == 0 &&
                std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; });
            return is_name ? "" : not_one_of(text, "letters, digits and `_`");
          },
          ""))
      ->type_name("NAME");
}
void add_reading(CLI::App& command, BridgeArguments& a) {
  command.add_option("--rate", a.rate, "values of each poster per second, if it has a reader (default: 10)")
      ->check(is_real(0.01, 1000))
      ->type_name("HZ");
  command.add_option("--yields", a.level.side_file, "file with additional facts, as for `bipc genom`")
      ->type_name("FILE");
  command
      .add_option("-I", a.level.compile.folders,
                  "search DIR for headers, after the folder of the file; may be repeated")
      ->allow_extra_args(false)
      ->type_name("DIR");
  command.add_option("-D", a.level.defines, "define a preprocessor macro; may be repeated")
      ->allow_extra_args(false)
      ->type_name("NAME[=VALUE]");
  add_diagnostics(command, a.level.compile);
}

}  // namespace

void add_ros1(CLI::App& app, BridgeArguments& a) {
  CLI::App* command = app.add_subcommand(
      "ros1", "connect services and posters of a served functional level to ROS 1, as actions and topics");
  add_level(*command, a, "ROS 1");
  add_reading(*command, a);
  command->footer(
      "The master is that of $ROS_MASTER_URI.\nExample:\n  bipc ros1 rover.gen --interfaces ws/src/rover_msgs\n"
      "  bipc ros1 rover.gen --serve /tmp/rover.sock");
}

void add_ros2(CLI::App& app, Ros2Arguments& a) {
  CLI::App* command = app.add_subcommand(
      "ros2", "connect services and posters of a served functional level to ROS 2, as actions and topics");
  add_level(*command, a.bridge, "ROS 2");
  command->add_option("--domain", a.domain, "domain of ROS 2 (default: $ROS_DOMAIN_ID, or 0)")
      ->check(is_number(0, 232))
      ->type_name("N");
  command
      ->add_option("--network", a.network,
                   "network interface, or `auto`: as Cyclone DDS is configured (default: lo, without multicast)")
      ->check(CLI::Validator(
          [](std::string& text) {
            const bool is_name = !text.empty() && text.find_first_of("<>&\"'") == std::string::npos;
            return is_name ? "" : not_one_of(text, "name of an interface, or `auto`");
          },
          ""))
      ->type_name("NAME");
  add_reading(*command, a.bridge);
  command->footer(
      "Example:\n  bipc ros2 rover.gen --interfaces ws/src/rover_msgs\n  bipc ros2 rover.gen --serve /tmp/rover.sock");
}

}  // namespace bip::driver
