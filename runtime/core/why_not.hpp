// Why an interaction is not possible in a state: which ports are missing and why, which guard is false, which priority
// hides it. The explanation of a whole deadlock is runtime/core/deadlock_explanation.hpp.
#pragma once
#include <string>

#include "runtime/core/core.hpp"

namespace bip::rt {

/// Lines, each with its newline; the first says whether the interaction is possible. Linear in the tree of the
/// connector, the rules about it and the candidates. The state must be a stable one.
[[nodiscard]] std::string why_not_connector(const Core& core, u32 connector);
/// The same of a port of an atom: is it enabled, and which connectors bind it?
[[nodiscard]] std::string why_not_port(const Core& core, u32 atom, u32 port);

}  // namespace bip::rt
