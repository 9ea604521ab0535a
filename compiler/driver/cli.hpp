// The command line of bipc.
#pragma once

namespace bip::driver {

/// What the program was built from; empty: not known, or not there.
struct BuildFacts {
  const char* commit = "";
  const char* llvm_version = "";
};

/// Reads the arguments, runs the command, returns the exit code (exit_codes.hpp). The whole of main().
[[nodiscard]] int run_command_line(int argc, char** argv, const BuildFacts& built);

}  // namespace bip::driver
