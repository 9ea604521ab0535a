// The options of each command, bound to its arguments. compiler/docs/cli.md is generated from the help texts.
#pragma once
#include <CLI/CLI.hpp>

#include "compiler/driver/options.hpp"

namespace bip::driver {

/// Everything that the command line can fill; one command's part is used.
struct Arguments {
  CheckArguments check;
  RunArguments run;
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
  VersionArguments version;
  Shell shell = Shell::Bash;
  PublishedArguments published;
  std::string explain_code;
  ColorChoice explain_color = ColorChoice::Auto;
};

/// Adds all commands to `app`, in the order of the help.
void add_commands(CLI::App& app, Arguments& arguments);

/// Prints the completion script of the commands of `app`.
[[nodiscard]] int command_completion(const CLI::App& app, Shell shell);

}  // namespace bip::driver
