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
  BuildArguments build;
  EmitArguments emit;
  GraphArguments graph;
  ExportArguments exported;
  ReplayArguments replay;
  FmtArguments fmt;
  MigrateArguments migrate;
  GenomArguments genom, rules;
  PublishedArguments published;
  std::string explain_code;
  ColorChoice explain_color = ColorChoice::Auto;
};

/// Adds all commands to `app`, in the order of the help.
void add_commands(CLI::App& app, Arguments& arguments);

/// -O.
void add_optimisation(CLI::App& command, Optimisation& level, bool with_o1, const std::string& help);

/// Of commands that run code.
void add_cache_options(CLI::App& command, CacheOptions& cache);

/// Of commands that run in real time.
void add_real_time_priority(CLI::App& command, int& priority);

/// Of `run`: options about the code that it makes and how it is watched. After --explore.
void add_code_options(CLI::App& command, RunArguments& arguments);

}  // namespace bip::driver
