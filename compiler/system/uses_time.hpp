// Does a System have clocks, urgency, `resume` or events? Commands for untimed systems ask first.
#pragma once
#include <string>

#include "compiler/system/system_ids.hpp"

namespace bip::system {

/// "atom type `Timer` has clock `x` (timer.bip:5:11)": the first thing in an instance's type that only means something
/// with time. Empty: there is none.
[[nodiscard]] std::string first_timed(const System& system);
/// The same of an action that takes time, by `resume`.
[[nodiscard]] std::string first_resume(const System& system);
/// The same of a port for events from outside; of one whose events carry a C++ object.
[[nodiscard]] std::string first_event_port(const System& system);
[[nodiscard]] std::string first_event_with_object(const System& system);
[[nodiscard]] inline bool is_timed(const System& system) { return !first_timed(system).empty(); }

}  // namespace bip::system
