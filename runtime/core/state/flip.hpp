// How a port that becomes enabled or disabled reaches the connectors above it, inlined into what moves ports one by
// one: an atom that has moved (atom_steps.cpp), one whose time has come (clocks.cpp), one that begins to work
// (partial.cpp). Cost: the counters above it; inner groups are crossed().
#pragma once
#include "bip/assert.hpp"
#include "runtime/core/core_parts.hpp"

namespace bip::rt {

[[gnu::always_inline]] inline void PortStates::flip(u32 instance, bool on) {
  BIP_ASSERT(instance < ports_.size(), "port {} of {}", instance, ports_.size());
  // Locals: a call might change members, for all that the compiler knows.
  std::int32_t* const values = values_.data();
  const std::int32_t by = on ? 1 : -1, crossing = on ? 0 : -1;
  for (const u32 node : core_.tables.port_out[instance]) {
    BIP_ASSERT(node < values_.size(), "node {} of {}", node, values_.size());
    const std::int32_t value = values[node] + by;
    values[node] = value;
    if (value == crossing) [[unlikely]]
      crossed(node, on);
  }
  if (!core_.tables.any_port_watch) return;
  const u32* const watch = core_.tables.port_watch.first.data() + instance;
  if (watch[0] != watch[1]) mark_watching(instance);
}

inline bool PortStates::exchange(u32 instance, u32 transition) {
  PortState& port = ports_[instance];
  BIP_ASSERT(port.place == kNone, "port {} of a simple type follows its atom's place", instance);
  BIP_ASSERT(transition == kNone || core_.tables.transitions[transition].port ==
                                        instance - core_.tables.port_base(core_.tables.port_atom[instance]),
             "transition {} does not label port {}", transition, instance);
  const u32 before = port.transition;
  port.transition = transition;
  return (before == kNone) != (transition == kNone);
}

inline void PortStates::set_port(u32 instance, u32 transition) {
  if (exchange(instance, transition)) flip(instance, transition != kNone);
}

}  // namespace bip::rt
