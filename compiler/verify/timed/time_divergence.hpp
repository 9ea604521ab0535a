// The time-divergent limit of a system: what can happen after time has passed without bound. Every clock that runs at
// speed 1 has exceeded every constant, so all lower bounds hold, no upper bound does, and no component is in a state
// whose invariant bounds a clock. A deadlock (time diverges and there never is a candidate) becomes a question about
// modes alone.
//
// R. Alur, D. Dill: A Theory of Timed Automata (1994), section 4.3: clock values above the largest constant are
// equivalent (the unbounded clock region). Limits that depend on data are treated as unknown.
#pragma once
#include <string>
#include <vector>

#include "compiler/verify/net/net.hpp"

namespace bip::verify {

/// Returns why the limit (or a localization of the system) is not defined, with a place in the source; empty: it is.
/// Linear.
[[nodiscard]] std::string obstacle_to_time_divergent_limit(const System& system);

/// Returns the untimed system of the limit. It has the same transitions; one that time may have disabled for good gets
/// a guard of unknown value and so is not surely enabled. The same holds for internal transitions that a clock decides
/// and for types that may stay busy for ever.
[[nodiscard]] System time_divergent_limit(const System& system);

/// Returns the modes of the atom in which time cannot diverge, as numbers of its class.
[[nodiscard]] std::vector<u32> bounded_modes(const Net& net, u32 atom);
/// Has the atom invariants over clocks?
[[nodiscard]] bool bounds_time(const System& system, AtomId atom);

}  // namespace bip::verify
