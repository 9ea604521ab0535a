// The command line of bipc.
#pragma once

namespace bip::driver {

/// Reads the arguments, runs the command, returns the exit code (exit_codes.hpp). The whole of main().
[[nodiscard]] int run_command_line(int argc, char** argv);

}  // namespace bip::driver
