// What the structure knows, in the machine's terms: each atom is in a reachable mode, traps and one-token invariants hold.
// Also the check that the ranges of data, which the machine's bits rest on, are kept by every step.
#pragma once
#include "compiler/verify/machine.hpp"
#include "compiler/verify/prove.hpp"

namespace bip::verify {

/// The signal of a mode: its places and no others are marked, its known values hold.
[[nodiscard]] Signal mode_signal(const Net& net, u32 mode, Machine& machine, const rt::Image& image);
[[nodiscard]] std::vector<std::vector<Signal>> mode_clauses(const Net& net, const Proof& proof, Machine& machine, const rt::Image& image);
[[nodiscard]] bool ranges_hold(const Machine& machine, double seconds);

}  // namespace bip::verify
