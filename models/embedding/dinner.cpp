// A shared library with a model inside: how long does a dinner last with this seed?
#include "bip/bip.hpp"
#include "philosophers.h"

extern "C" __attribute__((visibility("default"))) unsigned long long dinner_steps(unsigned long long seed) {
  bip::Execution table(philosophers::image(), {.seed = seed});
  return table.run(1'000'000);
}
