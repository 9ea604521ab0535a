// bipc: the program. All of it is in compiler/driver.
#include "compiler/driver/cli.hpp"

int main(int argc, char** argv) { return bip::driver::run_command_line(argc, argv, BIPC_COMMIT); }
