// The guard of a rendezvous in a localized system: the conjuncts that members and constant data decide. Weaker than the
// guard, never stronger; a conjunct that might end in a fault is left out. Internal to localization.hpp.
#pragma once
#include "compiler/verify/timed/localization.hpp"

namespace bip::verify {

struct LocalizedGuard {
  ExprId guard;                    // in the code that was given; invalid: true
  std::vector<std::int64_t> text;  // equal for equal guards; empty: true
};
/// Adds new expressions to `code`, which begins with the system's own. `inside`: the member ports, in the order of the
/// local connector's parameters.
[[nodiscard]] LocalizedGuard localize_guard(const System& system, const Neighbours::Top& top, CodeTable& code,
                                            const VariableFacts& constant, const std::vector<Neighbours::Leaf>& inside);

}  // namespace bip::verify
