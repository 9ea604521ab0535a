// Budgets of actions that run beside the others (`@async(budget="10ms")`): whose is over next, and what is said and
// done then.
#pragma once
#include <string>

#include "runtime/core/core.hpp"

namespace bip::rt {

/// Of those at work the one whose budget ends first, and of which nothing was said; kNone: none. O(actions at work).
[[nodiscard]] u32 next_overrun(const Core& core);
/// Its port for that, row of the core's event_ports(); kNone: none.
[[nodiscard]] u32 overrun_port(const Core& core, u32 atom);
/// With both instants, component, port, budget and place in the source.
[[nodiscard]] std::string overrun_text(const Core& core, u32 atom);

}  // namespace bip::rt
