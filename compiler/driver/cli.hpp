// The command line of bipc.
#pragma once

namespace bip::driver {

/// Reads the arguments, runs the command, returns the exit code (exit_codes.hpp). The whole of main(). `commit` is what
/// the program was built from, empty if that is not known.
[[nodiscard]] int run_command_line(int argc, char** argv, const char* commit);

}  // namespace bip::driver
