// Priorities between the ports of one atom.
//
// Rules with true guards are edges between ports. A port is hidden iff an enabled port can be reached from it; ports on
// the way need not be enabled. A cycle of such edges is a fault. Cost: the rules of the type (a wildcard counts as an
// edge for each port) whenever the atom's ports are looked at; types without rules never come here.
#pragma once
#include <vector>

#include "runtime/core/link/tables.hpp"

namespace bip::rt {

struct CoreParts;

class AtomPriorities {
 public:
  explicit AtomPriorities(CoreParts& core) : core_(core) {}
  /// Disables the ports that the atom's rules hide. transition_of_port: the enabled transition or kNone, changed.
  /// False: a fault.
  bool hide_ports(u32 atom, u32* transition_of_port);

 private:
  CoreParts& core_;
  std::vector<std::uint8_t> rule_holds_;   // by priority of the atom at hand
  std::vector<u32> rule_in_, rule_order_;  // by port of the atom at hand
};

}  // namespace bip::rt
