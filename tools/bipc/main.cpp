// bipc: the program. All of it is in compiler/driver.
#include "bip/process.hpp"
#include "compiler/driver/cli.hpp"

static int run_bipc(int argc, char** argv) {
  return bip::driver::run_command_line(argc, argv, {.commit = BIPC_COMMIT, .llvm_version = BIPC_LLVM_VERSION});
}

int main(int argc, char** argv) { return bip::run_process(run_bipc, argc, argv); }
