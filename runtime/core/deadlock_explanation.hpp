// Why a state is a deadlock, as text: the wait-for graph, and its shortest cycle if there is one.
#pragma once
#include <string>
#include <vector>

#include "runtime/core/core.hpp"

namespace bip::rt {

/// Several lines, the last with its newline. The state must have no candidate. Linear in the system.
[[nodiscard]] std::string deadlock_story(const Core& core, std::uint64_t steps, std::uint64_t seed);

/// A port that an atom offers in a deadlock, and the port of another one that is not there: kNone and kNone if no port
/// is missing but a guard, a priority or a connector.
struct DeadlockWait {
  u32 atom = 0, port = 0;
  u32 missing_atom = kNone, missing_port = kNone;
};
struct DeadlockWaits {
  std::vector<DeadlockWait> rows;  // by atom, at most 16 of each
  std::vector<u32> cycle;          // deadlock_cycle
};
/// Returns what each atom waits for.
[[nodiscard]] DeadlockWaits deadlock_waits(const Core& core);

/// Returns the atoms of a shortest cycle of that graph, each waits for the next one; empty if there is none.
[[nodiscard]] std::vector<u32> deadlock_cycle(const Core& core);

}  // namespace bip::rt
