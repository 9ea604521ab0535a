// How single connectors use a port: what they write into the atom, and of which of its values their guard wants. "Pay
// of customer 7 puts 3 into `order`; SwitchOn of pump 3 wants `order` to be 3": so an atom's modes can tell values that
// come from outside.
//
// A use is distinguished only where what others contribute never changes: then it is a port of its own in the network
// (Net), with fewer moves than the port has in general. Looked at are rendezvous of atoms with at most one clause and
// no `up`. Cost: linear in the connectors.
#pragma once
#include <compare>
#include <cstdint>
#include <vector>

#include "compiler/system/system_ids.hpp"
#include "compiler/verify/net/abstract_code.hpp"

namespace bip::verify {

struct Net;

/// A Bind variable of a guard: a variable of the atom itself, or a value.
struct UseSource {
  static constexpr std::uint32_t kOther = 0xffffffffu;
  std::uint32_t own_variable = kOther;
  AbstractValue value;
  friend auto operator<=>(const UseSource&, const UseSource&) = default;
};
struct PortUse {
  std::uint32_t port = 0;
  std::vector<std::pair<std::uint32_t, AbstractValue>> writes;  // by variable: what it is before the port fires
  ExprId guard;                                                 // invalid: none that only the atom decides
  std::vector<UseSource> bind;                                  // of the guard
  friend auto operator<=>(const PortUse&, const PortUse&) = default;
};
/// Of an atom: the distinguished uses, sorted; and which ports are used in other ways, too.
struct AtomUses {
  std::vector<PortUse> uses;
  std::vector<std::uint8_t> is_plain;  // by port; empty: all
  friend auto operator<=>(const AtomUses&, const AtomUses&) = default;
};
struct PortUses {
  std::vector<AtomUses> of_atom;
  std::vector<std::vector<std::uint32_t>>
      of_param;  // by connector and parameter: row of the atom's uses + 1, 0: plain; may be empty
  bool has_some = false;
};

/// `net`: the system without uses told apart, for what never changes.
[[nodiscard]] PortUses find_port_uses(const Net& net);

}  // namespace bip::verify
