// What is left of a rendezvous' guard when some of its atoms are cut off: the conjuncts that those who stay and data
// that never change decide. Weaker than the guard, never stronger; what might end in a fault is left out. Internal to
// localization.hpp.
#pragma once
#include "compiler/verify/timed/localization.hpp"

namespace bip::verify {

struct LocalizedGuard {
  ExprId guard;                    // in the code that was given; invalid: true
  std::vector<std::int64_t> text;  // equal for equal guards; empty: true
};
/// inside: the leaves that stay, in the order of the cut connector's parameters. New expressions are added to `code`,
/// which begins with the system's own.
[[nodiscard]] LocalizedGuard cut_guard(const System& system, const Neighbours::Top& top, CodeTable& code,
                                       const KnownVariable& constant, const std::vector<Neighbours::Leaf>& inside);

}  // namespace bip::verify
