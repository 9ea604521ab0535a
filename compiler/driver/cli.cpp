// Selects a command from argv. CLI11 parses the options; an error in them is exit code 2 with one line and a hint.
#include "compiler/driver/cli.hpp"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "compiler/driver/cli_options.hpp"
#include "compiler/driver/help_formatter.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/file_options.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/pipeline/host_compiler.hpp"

namespace bip::driver {
namespace {

bool is_command(const CLI::App& app, const std::string& word) {
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    if (command->get_name() == word) return true;
  }
  return false;
}

// A first argument that is neither an option nor a command: CLI11 would only call it unexpected.
int unknown_command(const CLI::App& app, const std::string& word) {
  std::vector<std::string> known;
  for (const CLI::App* command : app.get_subcommands(nullptr)) known.push_back(command->get_name());
  if (word.ends_with(".bip") || word.ends_with(".bsys")) {
    return usage_error(fmt::format("`{}` is a file, a command comes first", word), fmt::format("`bipc run {}`", word));
  }
  const std::vector<std::string> similar = similar_names(word, known);
  return usage_error(fmt::format("no command `{}`", word), similar.empty()
                                                               ? "`bipc --help` lists the commands"
                                                               : fmt::format("there is `{}`", similar.front()));
}

// Which command the person was in, for the hint.
std::string help_of(const CLI::App& app, int argc, char** argv) {
  const std::string first = argc > 1 ? argv[1] : "";
  return is_command(app, first) ? fmt::format("`bipc {} --help`", first) : "`bipc --help`";
}

// `bipc help [command]`, as git has it.
int print_help(const CLI::App& app, int argc, char** argv) {
  if (argc > 3) return usage_error(fmt::format("`{}` is one argument too many", argv[3]), "`bipc help COMMAND`");
  if (argc == 3 && !is_command(app, argv[2])) return unknown_command(app, argv[2]);
  std::fputs((argc == 3 ? app.get_subcommand(argv[2])->help("bipc") : app.help()).c_str(), stdout);
  return kOk;
}

// An option that the command does not have, or one file too many.
int unexpected_word(const CLI::App& app, const std::string& help) {
  const CLI::App* command = app.get_subcommands().empty() ? &app : app.get_subcommands().front();
  const std::vector<std::string> words = app.remaining(true);
  const std::string word = words.empty() ? "" : words.front();
  if (!word.starts_with('-')) return usage_error(fmt::format("`{}` is one argument too many", word), help);
  std::vector<std::string> known;
  for (const CLI::Option* option : command->get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  }
  const std::vector<std::string> similar = similar_names(word.substr(0, word.find('=')), known);
  return usage_error(fmt::format("no option `{}` here", word),
                     similar.empty() ? help : fmt::format("there is `{}`", similar.front()));
}

// As getopt does: the beginning of a long option stands for it if no other option has a name that begins so.
std::vector<std::string> with_whole_options(const CLI::App& app, int argc, char** argv) {
  struct LongName {
    std::string name;
    const CLI::Option* option;
  };
  std::vector<LongName> known;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back({"--" + name, option});
  }
  std::vector<std::string> words;
  for (int i = 1; i < argc; ++i) {
    std::string word = argv[i];
    const std::size_t end = std::min(word.find('='), word.size());
    const std::string name = word.substr(0, end);
    std::vector<LongName> meant;
    for (const LongName& long_name : known) {
      if (name.size() > 2 && long_name.name.starts_with(name)) meant.push_back(long_name);
    }
    const bool is_whole =
        std::any_of(meant.begin(), meant.end(), [&](const LongName& long_name) { return long_name.name == name; });
    const bool is_clear = !meant.empty() && std::all_of(meant.begin(), meant.end(), [&](const LongName& long_name) {
      return long_name.option == meant.front().option;
    });
    if (!is_whole && is_clear) word = meant.front().name + word.substr(end);
    words.push_back(std::move(word));
  }
  return words;
}

// The process that works on a command; 0: none does. Children of ours end as they like.
std::atomic<pid_t> working_process{0};

// C++ of a model may call exit(). What a command would have printed is lost then, so it has failed whatever the code.
void report_early_exit() {
  if (working_process.load() != ::getpid()) return;
  std::fflush(nullptr);
  print_error_text("error: the model's C++ called exit() before the command had ended: its results are lost\n");
  std::fflush(stderr);
  std::_Exit(kModelErrors);
}

class WorkingNote {
 public:
  WorkingNote() {
    (void)std::atexit(report_early_exit);
    working_process.store(::getpid());
  }
  WorkingNote(const WorkingNote&) = delete;
  WorkingNote& operator=(const WorkingNote&) = delete;
  ~WorkingNote() { working_process.store(0); }
};

int dispatch(const CLI::App& app, const Arguments& arguments) {
  const std::string& command = app.get_subcommands().front()->get_name();
  const WorkingNote working;
  if (command == "check") return command_check(arguments.check);
  if (command == "run") return command_run(arguments.run);
  if (command == "deploy") return command_deploy(arguments.deploy);
  if (command == "node") return command_node(arguments.node);
  if (command == "verify") return command_verify(arguments.verify);
  if (command == "explore") return command_explore(arguments.explore);
  if (command == "simulate") return command_simulate(arguments.simulate);
  if (command == "step") return command_step(arguments.step);
  if (command == "view") return command_view(arguments.view);
  if (command == "trace") return command_trace(arguments.trace);
  if (command == "dap") return command_dap();
  if (command == "serve") return command_serve(arguments.serve);
  if (command == "build") return command_build(arguments.build);
  if (command == "emit") return command_emit(arguments.emit);
  if (command == "graph") return command_graph(arguments.graph);
  if (command == "export") return command_export(arguments.exported);
  if (command == "replay") return command_replay(arguments.replay);
  if (command == "genom") return command_genom(arguments.genom);
  if (command == "rules") return command_rules(arguments.rules);
  if (command == "ros1") return command_ros1(arguments.ros1);
  if (command == "ros2") return command_ros2(arguments.ros2);
  if (command == "migrate") return command_migrate(arguments.migrate);
  if (command == "fmt") return command_fmt(arguments.fmt);
  if (command == "explain") return command_explain(arguments.explain_code, arguments.explain_color);
  if (command == "completion") return command_completion(app, arguments.shell);
  return command_version(arguments.version);
}

// A signal that came while a compiler ran has ended the compiler only: temporary files are removed by now.
int end_by_signal(int code) {
  const int signal = signal_during_program();
  if (signal == 0) return code;
  std::fflush(stdout);
  std::signal(signal, SIG_DFL);
  std::raise(signal);
  return 128 + signal;
}

}  // namespace

int run_command_line(int argc, char** argv, const BuildFacts& built) {
  CLI::App app{"bipc: compiler and runtime for BIP models", "bipc"};
  app.require_subcommand(0, 1);
  app.set_help_flag("-h,--help", "print this help");
  app.set_help_all_flag("--help-all", "print this help with all options");
  app.footer(
      "Example:\n  bipc run model.bip\n`bipc help COMMAND` prints the help of a command; FILE may be `-`, standard "
      "input.");
  const std::string_view first = argc > 1 ? argv[1] : "";
  Arguments arguments;
  arguments.version.commit = built.commit;
  arguments.version.llvm_version = built.llvm_version;
  add_commands(app, arguments, first);
  hide_rare_options(app);
  for (CLI::App* command : app.get_subcommands(nullptr)) {
    // Options of -O and --color kind may be repeated: the last one counts, as compilers do.
    for (CLI::Option* option : command->get_options()) {
      // -I and --Werror=CODE add up.
      if (option->get_positional() || option->get_expected_max() != 1 || option->get_expected_min() == 0) continue;
      option->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    }
  }
  if (first == "help") return print_help(app, argc, argv);
  if (argc > 1 && argv[1][0] != '-' && !is_command(app, argv[1])) return unknown_command(app, argv[1]);
  if (first == "--version" || first == "-V") return command_version({});
  try {
    // The published compiler's call has no command. Words come last first.
    if (argc > 1 && argv[1][0] == '-') {
      std::vector<std::string> words = with_whole_options(app, argc, argv);
      std::reverse(words.begin(), words.end());
      app.parse(std::move(words));
    } else {
      app.parse(argc, argv);
    }
  } catch (const CLI::CallForHelp& e) {
    return app.exit(e);
  } catch (const CLI::CallForAllHelp& e) {
    return app.exit(e);
  } catch (const CLI::CallForVersion&) {
    return command_version({});
  } catch (const CLI::ExtrasError&) {
    return unexpected_word(app, help_of(app, argc, argv));
  } catch (const CLI::ParseError& e) {
    // Hidden options have no name there; their messages name them.
    std::string_view problem = e.what();
    if (problem.starts_with(": ")) problem.remove_prefix(2);
    return usage_error(std::string(problem), help_of(app, argc, argv));
  }
  if (!arguments.published.package.empty() || !arguments.published.file.empty()) {
    if (!app.get_subcommands().empty()) return usage_error("`-p` and `-f` go without a command", "`bipc --help`");
    return end_by_signal(command_published(arguments.published));
  }
  if (app.get_subcommands().empty()) {
    std::fputs(app.help().c_str(), stdout);
    return argc > 1 ? kUsage : kOk;
  }
  if (first == "replay" && arguments.replay.published_trace.empty() && arguments.replay.recorded_trace.empty()) {
    return usage_error("a trace is needed: --published or --recorded", help_of(app, argc, argv));
  }
  if (const std::string option = nameless_file(*app.get_subcommands().front()); !option.empty())
    return usage_error(fmt::format("the value of {} is empty, a path was expected", option), help_of(app, argc, argv));
  const std::string conflict = file_conflict(*app.get_subcommands().front());
  if (!conflict.empty()) return usage_error(conflict);
  return end_by_signal(dispatch(app, arguments));
}

}  // namespace bip::driver
