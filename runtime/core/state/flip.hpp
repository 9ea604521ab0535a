// How a port that becomes enabled or disabled reaches the connectors above it, inlined into what moves ports one by
// one: an atom that has moved (enabled.cpp), and one whose time has come (timed_ports.cpp). Cost: the counters above
// it; inner groups are crossed().
#pragma once
#include "runtime/core/core.hpp"

namespace bip::rt {

inline void Core::bump(u32 node, bool on) {
  if (on ? ++values_[node] != 0 : values_[node]-- != 0) return;
  if (!direct_.has(node) || tables_.any_searched) crossed(node, on);
  else if (on) enabled_.insert(node);
  else enabled_.erase(node);
}

inline void Core::flip(u32 instance, bool on) {
  for (const u32 node : tables_.port_out[instance]) bump(node, on);
  if (tables_.any_port_watch) {
    for (u32 interaction : tables_.port_watch[instance]) {
      if (values_[interaction] >= 0) mark_dirty(interaction);
    }
  }
}

inline void Core::set_port(u32 instance, u32 transition) {
  PortState& port = ports_[instance];
  const u32 before = port.transition;
  port.transition = transition;
  if ((before == kNone) != (transition == kNone)) flip(instance, transition != kNone);
}

}  // namespace bip::rt
