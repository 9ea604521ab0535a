// A system as it is when nothing has happened for very long: every clock that runs at speed 1 is beyond every constant.
// So lower bounds of clocks hold, upper ones do not, and nobody can be where an invariant bounds a clock: a deadlock, a
// state from which time passes for ever without a candidate, becomes a question about modes alone.
#pragma once
#include <string>
#include <vector>

#include "compiler/verify/net/net.hpp"

namespace bip::verify {

/// Empty, or what of the system has no such end, or what parts of it (localization.hpp) cannot say, with its place.
/// Linear.
[[nodiscard]] std::string obstacle_to_time_divergent_limit(const System& system);

/// The same moves; a transition that time may have closed for good has a guard that nobody knows, and so is not sure.
/// So it is with internal ones that a clock decides, and with types that may be busy for ever.
[[nodiscard]] System time_divergent_limit(const System& system);

/// Modes of the atom in which time cannot pass for ever, as numbers of its class.
[[nodiscard]] std::vector<u32> bounded_modes(const Net& net, u32 atom);
/// Has it invariants that speak of clocks?
[[nodiscard]] bool bounds_time(const System& system, AtomId atom);

}  // namespace bip::verify
