// The options of each command, bound to its arguments. compiler/docs/cli.md is generated from the help texts.
#pragma once
#include <string_view>

#include <CLI/CLI.hpp>

#include "compiler/driver/options.hpp"

namespace bip::driver {

/// Everything that the command line can fill; one command's part is used.
struct Arguments {
  CheckArguments check;
  RunArguments run;
  DeployArguments deploy;
  NodeArguments node;
  StepArguments step;
  ViewArguments view;
  TraceArguments trace;
  ServeArguments serve;
  VerifyArguments verify;
  ExploreArguments explore;
  SimulateArguments simulate;
  BuildArguments build;
  EmitArguments emit;
  GraphArguments graph;
  ExportArguments exported;
  ReplayArguments replay;
  FmtArguments fmt;
  MigrateArguments migrate;
  GenomArguments genom, rules;
  BridgeArguments ros1;
  Ros2Arguments ros2;
  VersionArguments version;
  Shell shell = Shell::Bash;
  PublishedArguments published;
  std::string explain_code;
  ColorChoice explain_color = ColorChoice::Auto;
};

/// Adds the command that `first`, the first argument, names; all commands, in the order of the help, if it names none
/// or the command prints all. Most of what `bipc` does before it works is to add options.
void add_commands(CLI::App& app, Arguments& arguments, std::string_view first);

// Parts of it, in other files than the rest.
void add_genom(CLI::App& app, GenomArguments& a);
void add_rules(CLI::App& app, GenomArguments& a);
void add_ros1(CLI::App& app, BridgeArguments& a);
void add_ros2(CLI::App& app, Ros2Arguments& a);
void add_verify(CLI::App& app, VerifyArguments& a);
void add_explore(CLI::App& app, ExploreArguments& a);
void add_simulate(CLI::App& app, SimulateArguments& a);
/// Folders for hosts, and nodes there.
void add_deploy(CLI::App& app, DeployArguments& a);
void add_node(CLI::App& app, NodeArguments& a);
void add_export(CLI::App& app, ExportArguments& a);
void add_graph(CLI::App& app, GraphArguments& a);
void add_view(CLI::App& app, ViewArguments& a);
void add_trace(CLI::App& app, TraceArguments& a);
/// The options about errors and warnings.
void add_diagnostics(CLI::App& app, CompileOptions& options);
/// The refusal of a value that an option does not take.
[[nodiscard]] std::string not_one_of(const std::string& text, const std::string& shown);

/// Prints the completion script of the commands of `app`.
[[nodiscard]] int command_completion(const CLI::App& app, Shell shell);

}  // namespace bip::driver
