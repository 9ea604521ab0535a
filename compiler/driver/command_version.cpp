// `bipc version`: prints one fact per line, for bug reports.
#include <cstdio>

#include "compiler/driver/commands.hpp"
#include "compiler/driver/exit_codes.hpp"
#include "compiler/driver/jit_loader.hpp"

#ifndef BIPC_VERSION
#define BIPC_VERSION "unknown"
#endif

namespace bip::driver {

int command_version() {
  std::printf("bipc %s\n", BIPC_VERSION);
  std::printf("back ends: %sinterp, c++\n", load_jit() ? "jit, " : "");
  return kOk;
}

}  // namespace bip::driver
