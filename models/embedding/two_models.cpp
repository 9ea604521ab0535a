// Two models in one program, each in its own namespace, step by step in turn.
#include <cstdio>

#include "bip/bip.hpp"
#include "philosophers.h"
#include "ring.h"

int main() {
  bip::Execution table(philosophers::image(), {.seed = 4});
  bip::Execution ring(ring::image(), {.seed = 1});
  table.on_step([](const bip::Step& step) { std::printf("table: %s\n", step.interaction.c_str()); });
  while (table.step() == bip::Outcome::Stepped) {
    if (ring.step() != bip::Outcome::Stepped) return 1;
  }
  std::printf("the table is at its deadlock after %llu steps, the ring goes on: %llu\n",
              static_cast<unsigned long long>(table.steps()), static_cast<unsigned long long>(ring.run(1000)));
  return table.outcome() == bip::Outcome::Deadlock && table.steps() == 5 && ring.outcome() == bip::Outcome::Stepped ? 0
                                                                                                                    : 1;
}
