// See limiting_ports.hpp.
#include "runtime/engine/limiting_ports.hpp"

#include <algorithm>

namespace bip::rt {

// Ports of a transition that is urgent, or possible at some instants only.
LimitingPorts::LimitingPorts(const Core& core) {
  const Tables& tables = core.tables();
  for (u32 atom = 0; atom < core.image().atoms.size; ++atom) {
    const AtomType& type = tables.atom_type(atom);
    if (type.time == nullptr) continue;
    std::vector<bool> may_limit(type.ports.size);
    for (u32 row = 0; row < type.transitions.size; ++row) {
      const TransitionTime& timing = type.time->transitions[row];
      const u32 port = type.transitions[row].port;
      if (port != kNone && (timing.urgency != Urgency::Lazy || timing.when.bounds.size != 0)) may_limit[port] = true;
    }
    for (u32 port = 0; port < type.ports.size; ++port) {
      if (may_limit[port]) ports_.push_back(tables.instance(atom, port));
    }
  }
}

i64 LimitingPorts::latest(Core& core, TimedScheduler& scheduler) const {
  // A look at a port costs a fraction of one at a candidate.
  constexpr u64 kPortsForACandidate = 8;
  Clocks& time = core.time();
  const bool is_limited = ports_.size() > kPortsForACandidate * core.candidate_count() ||
                          std::any_of(ports_.begin(), ports_.end(), [&](u32 instance) {
                            const PortTime& port = time.port_time(instance);
                            return (port.urgency != Urgency::Lazy || port.interval.high != kForever) &&
                                   core.parts().ports.enabled_row(instance) != kNone;
                          });
  if (is_limited) return scheduler.latest(core);
  const i64 last = time.last_instant();
  const i64 limit = last > core.now() && time.is_before_eager() ? core.now() : std::max(last, core.now());
  BIP_ASSERT(limit == scheduler.latest(core), "a step may start until {}", limit);
  return limit;
}

}  // namespace bip::rt
