// Makes faults: fills CoreParts::fault with what went wrong and where. Every function returns false, for `return
// faults.fail(...)`.
#pragma once
#include <vector>

#include "runtime/core/fire/fault.hpp"
#include "runtime/core/link/tables.hpp"

namespace bip::rt {

struct CoreParts;

class FaultReporter {
 public:
  explicit FaultReporter(CoreParts& core) : core_(core) {}

  /// Two transitions enabled, not 1-safe, endless internal transitions. other: null, or the second transition.
  bool fail(FaultCode code, u32 atom, const Transition* transition, const Transition* other);
  /// Code returned a status >= 2 (bip/image.hpp). atom, connector: whose code it was; both kNone: a rule's guard. rule:
  /// the name of the invariant or priority that it belongs to, or null.
  bool fail_code(std::int32_t status, u32 atom, u32 connector, const Transition* transition,
                 const char* rule = nullptr);
  bool fail_invariant(u32 atom, const Invariant& invariant, const Transition* fired);
  /// Priorities of the atom, rows of its type's, close a cycle.
  bool fail_atom_rules(u32 atom, const std::vector<u32>& rules);
  /// A connector has too many interactions.
  bool fail_connector(FaultCode code, u32 connector);
  /// Priorities between interactions close a cycle.
  bool fail_rules(const std::vector<u32>& rules);

 private:
  CoreParts& core_;
};

}  // namespace bip::rt
