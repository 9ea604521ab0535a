// libFuzzer's entry: one program a target, BIPC_FUZZ_TARGET is its name.
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/targets.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const bip::fuzz::Target target = bip::fuzz::find_target(BIPC_FUZZ_TARGET);
  const std::string problem = target(std::string_view(reinterpret_cast<const char*>(data), size)).problem;
  if (!problem.empty()) {
    std::fprintf(stderr, "%s\n", problem.c_str());
    std::abort();
  }
  return 0;
}
