// The tick by hand: one interaction, n counters. `naive` stores one record per atom and reads all of them before it
// fires.
#include "limit.hpp"

namespace {

using limit::u32;

struct Atom {
  u32 place = 0, count = 0;
  u32 rest[14] = {};  // what an engine keeps with an atom: a cache line
};

}  // namespace

int main(int argc, char** argv) {
  const limit::Arguments arguments = limit::read_arguments(argc, argv);
  limit::u64 sum = 0;
  if (arguments.naive) {
    std::vector<Atom> atoms(arguments.n);
    const double start = limit::cpu_seconds();
    for (limit::u64 step = 0; step < arguments.steps; ++step) {
      bool is_enabled = true;
      for (const Atom& atom : atoms) is_enabled &= atom.place == 0;
      if (!is_enabled) return 1;
      for (Atom& atom : atoms) ++atom.count;
      asm volatile("" ::: "memory");
    }
    for (const Atom& atom : atoms) sum += atom.count;
    limit::report(arguments.steps, limit::cpu_seconds() - start, sum);
    return 0;
  }
  std::vector<u32> counts(arguments.n, 0);
  const double start = limit::cpu_seconds();
  for (limit::u64 step = 0; step < arguments.steps; ++step) {
    for (u32& count : counts) ++count;
    asm volatile("" ::: "memory");
  }
  for (u32 count : counts) sum += count;
  limit::report(arguments.steps, limit::cpu_seconds() - start, sum);
}
