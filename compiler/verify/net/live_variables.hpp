// Where the value of a variable still matters: some way on from a place reads it before it is given a new one.
// Elsewhere modes need not tell values apart. Nothing rests on this: a value that is forgotten may be any. Backward to
// a fixpoint, for automata only.
#pragma once
#include "compiler/analysis/data_access.hpp"
#include "compiler/verify/net/port_uses.hpp"

namespace bip::verify {

/// By place, by variable; empty: everything may matter.
[[nodiscard]] std::vector<std::vector<std::uint8_t>> find_live_variables(const System& system, AtomTypeId type,
                                                                         const analysis::DataAccess& access,
                                                                         const AtomUses& uses);

}  // namespace bip::verify
