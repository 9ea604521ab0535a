// See atom_steps.hpp.
#include "runtime/core/state/atom_steps.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "bip/assert.hpp"
#include "runtime/core/state/flip.hpp"

namespace bip::rt {

namespace {
// Variables of an atom that are compared before and after a transition: more than that cost as much as what they save.
constexpr u32 kMostCompared = 16;
using DataBefore = std::array<Cell, kMostCompared>;
}  // namespace

void AtomSteps::link() {
  u32 ports = 0;
  for (const AtomType& type : core_.image().atom_types) ports = std::max(ports, type.ports.size);
  port_scratch_.assign(ports, kNone);
}

bool AtomSteps::is_enabled_from(u32 atom, const LinkedTransition& transition, bool& enabled) {
  const AtomInfo& state = core_.atoms[atom];
  enabled = true;
  if (transition.from == kNone) {
    for (u32 place : transition.source->from) {
      if (!core_.is_marked(atom, place)) {
        enabled = false;
        return true;
      }
    }
  }
  if (transition.guard.fn == nullptr) return true;
  const std::int32_t status = transition.guard.fn(transition.guard.context, core_.memory.cells.from(state.first_cell),
                                                  core_.memory.cells.all(), nullptr);
  BIP_ASSERT(status >= 0, "a guard of atom {} returns {}", atom, status);
  if (status >= 2) return core_.faults.fail_code(status, atom, kNone, transition.source);
  enabled = status != 0;
  return true;
}

bool AtomSteps::move_tokens(u32 atom, const LinkedTransition& transition) {
  BIP_ASSERT(
      transition.from == kNone || core_.memory.places[atom] == transition.from || core_.memory.places[atom] == kNone,
      "atom {} is at place {}", atom, core_.memory.places[atom]);
  if (transition.to != kNone) {
    core_.memory.places[atom] = transition.to;
  } else {
    u64* marks = core_.memory.marks.data() + core_.tables.first_mark(atom);
    for (u32 place : transition.source->from) marks[place >> 6] &= ~(u64{1} << (place & 63));
    for (u32 place : transition.source->to) {
      BIP_ASSERT(place < core_.tables.atom_type(atom).places.size, "place {} of atom {}", place, atom);
      const u64 bit = u64{1} << (place & 63);
      if ((marks[place >> 6] & bit) != 0)
        return core_.faults.fail(FaultCode::NotOneSafe, atom, transition.source, nullptr);
      marks[place >> 6] |= bit;
    }
  }
  return true;
}

// Tokens, then the action.
inline bool AtomSteps::move(u32 atom, const LinkedTransition& transition) {
  const AtomInfo& state = core_.atoms[atom];
  if (transition.to != kNone) core_.memory.places[atom] = transition.to;
  else if (!move_tokens(atom, transition)) return false;
  if (transition.action.fn != nullptr) {
    const bool is_timed = core_.tables.types[state.type].is_timed;
    if (is_timed) core_.clocks.show_clocks(atom);
    const std::int32_t status = transition.action.fn(
        transition.action.context, core_.memory.cells.from(state.first_cell), core_.memory.cells.all(), nullptr);
    if (status >= 2) return core_.faults.fail_code(status, atom, kNone, transition.source);
    if (is_timed && !core_.clocks.read_clocks(atom, transition.source)) return false;
  }
  return true;
}

// The internal transition that is enabled, null if none is.
bool AtomSteps::find_internal(u32 atom, const LinkedTransition*& found) {
  const LinkedType& type = core_.tables.types[core_.atoms[atom].type];
  BIP_ASSERT(type.mark_words != 0 || core_.memory.places[atom] < core_.tables.atom_type(atom).places.size,
             "atom {} is at place {}", atom, core_.memory.places[atom]);
  found = nullptr;
  const auto look = [&](const LinkedTransition& transition) {
    bool enabled = false;
    if (!is_enabled_from(atom, transition, enabled)) return false;
    if (!enabled) return true;
    if (found != nullptr) return core_.faults.fail(FaultCode::TwoInternals, atom, found->source, transition.source);
    found = &transition;
    return true;
  };
  if (type.mark_words == 0) {
    for (u32 row : core_.tables.place_internals[type.first_place + core_.memory.places[atom]]) {
      if (!look(core_.tables.transitions[row])) return false;
    }
    return true;
  }
  for (u32 i = 0; i < type.transition_count; ++i) {
    const LinkedTransition& transition = core_.tables.transitions[type.first_transition + i];
    if (transition.port == kNone && !look(transition)) return false;
  }
  return true;
}

bool AtomSteps::run_internals(u32 atom) {
  const LinkedType& type = core_.tables.types[core_.atoms[atom].type];
  for (std::uint32_t run = 0;; ++run) {
    const LinkedTransition* found = nullptr;
    if (!find_internal(atom, found)) return false;
    if (found == nullptr) return true;
    if (run >= core_.options.internal_bound)
      return core_.faults.fail(FaultCode::EndlessInternals, atom, found->source, nullptr);
    if (!move(atom, *found)) return false;
    if (type.has_invariants && !check_invariants(atom, found)) return false;
  }
}

// If the transition is enabled, it is the one of its port.
inline bool AtomSteps::look_at(u32 atom, u32 row) {
  const LinkedTransition& transition = core_.tables.transitions[row];
  bool enabled = false;
  if (!is_enabled_from(atom, transition, enabled)) return false;
  if (!enabled) return true;
  u32& enabled_row = port_scratch_[transition.port];
  BIP_ASSERT(transition.port < core_.tables.atom_type(atom).ports.size, "port {} of atom {}", transition.port, atom);
  if (enabled_row != kNone) {
    return core_.faults.fail(FaultCode::TwoTransitions, atom, core_.tables.transitions[enabled_row].source,
                             transition.source);
  }
  enabled_row = row;
  return true;
}

// Ports of an automaton with at most one transition for each place and port: only those that the two places offer can
// change.
static inline bool update_places(CoreParts& core, u32 atom, u32 place_before) {
  const AtomInfo& state = core.atoms[atom];
  const u32 first_place = core.tables.types[state.type].first_place;
  const u32 place_now = core.memory.places[atom];
  Cell* const all = core.memory.cells.all();
  for (const u32 row : core.tables.place_transitions[first_place + place_now]) {
    const LinkedTransition& transition = core.tables.transitions[row];
    std::int32_t status = 1;
    if (transition.guard.fn != nullptr) {
      status = transition.guard.fn(transition.guard.context, core.memory.cells.from(state.first_cell), all, nullptr);
      BIP_ASSERT(status >= 0, "a guard of atom {} returns {}", atom, status);
      if (status >= 2) return core.faults.fail_code(status, atom, kNone, transition.source);
    }
    core.ports.set_port(state.port_base + transition.port, status != 0 ? row : kNone);
  }
  if (place_before == place_now) return true;
  // What a port still has from the old place is not offered by the new one.
  for (const u32 row : core.tables.place_transitions[first_place + place_before]) {
    const u32 instance = state.port_base + core.tables.transitions[row].port;
    if (core.ports.port(instance).transition == row) core.ports.set_port(instance, kNone);
  }
  return true;
}

bool AtomSteps::update_ports(u32 atom, u32 place_before) {
  const AtomInfo& state = core_.atoms[atom];
  const LinkedType& type = core_.tables.types[state.type];
  const u32 place_now = core_.memory.places[atom];
  BIP_ASSERT(type.mark_words != 0 || place_now < core_.tables.atom_type(atom).places.size, "atom {} is at place {}",
             atom, place_now);
  if (type.simple) {
    if (place_before == place_now) return true;
    if (place_before != kNone) {
      for (u32 row : core_.tables.place_transitions[type.first_place + place_before]) {
        core_.ports.flip(state.port_base + core_.tables.transitions[row].port, false);
      }
    }
    for (u32 row : core_.tables.place_transitions[type.first_place + place_now]) {
      core_.ports.flip(state.port_base + core_.tables.transitions[row].port, true);
    }
    return true;
  }
  if (type.is_timed) return core_.clocks.look_at_time(atom);
  u32* now = port_scratch_.data();
  if (type.mark_words == 0 && place_before != kNone && !type.has_priorities) {
    // Only ports that the two places offer can change.
    const Span<u32> old_rows = core_.tables.place_transitions[type.first_place + place_before];
    const Span<u32> rows = core_.tables.place_transitions[type.first_place + place_now];
    if (type.one_each) return update_places(core_, atom, place_before);
    for (u32 row : rows) now[core_.tables.transitions[row].port] = kNone;
    if (place_before != place_now) {
      for (u32 row : old_rows) now[core_.tables.transitions[row].port] = kNone;
    }
    for (u32 row : rows) {
      if (!look_at(atom, row)) return false;
    }
    if (place_before != place_now) {
      for (u32 row : old_rows) {
        const u32 port = core_.tables.transitions[row].port;
        core_.ports.set_port(state.port_base + port, now[port]);
      }
    }
    for (u32 row : rows) {
      const u32 port = core_.tables.transitions[row].port;
      core_.ports.set_port(state.port_base + port, now[port]);
    }
    return true;
  }
  if (!find_ports(atom)) return false;
  const u32 ports = core_.tables.port_base(atom + 1) - state.port_base;
  for (u32 port = 0; port < ports; ++port) core_.ports.set_port(state.port_base + port, now[port]);
  return true;
}

bool AtomSteps::find_ports(u32 atom) {
  const LinkedType& type = core_.tables.types[core_.atoms[atom].type];
  if (type.is_timed) return core_.clocks.find_ports(atom);
  u32* now = port_scratch_.data();
  const u32 ports = core_.tables.port_base(atom + 1) - core_.tables.port_base(atom);
  for (u32 port = 0; port < ports; ++port) now[port] = kNone;
  if (type.mark_words == 0) {
    for (u32 row : core_.tables.place_transitions[type.first_place + core_.memory.places[atom]]) {
      if (!look_at(atom, row)) return false;
    }
  } else {
    for (u32 i = 0; i < type.transition_count; ++i) {
      if (core_.tables.transitions[type.first_transition + i].port == kNone) continue;
      if (!look_at(atom, type.first_transition + i)) return false;
    }
  }
  return !type.has_priorities || core_.atom_priorities.hide_ports(atom, now);
}

// fired: null for `initial`.
bool AtomSteps::settle_atom(u32 atom, u32 place_before, const LinkedTransition* fired) {
  const LinkedType& type = core_.tables.types[core_.atoms[atom].type];
  if (type.has_internal && !run_internals(atom)) return false;
  if (type.is_timed) return core_.clocks.begin_resume(atom, fired) && core_.clocks.look_at_time(atom);
  return update_ports(atom, place_before);
}

// How many bytes of the atom's data tell whether the transition changes what others read; 0: it counts as a change.
// Data that a port shows may have been written by the transfer before.
static std::size_t compared_data(const CoreParts& core, u32 atom, const LinkedTransition& transition) {
  if (core.tables.types[core.atoms[atom].type].is_timed) return 0;
  const AtomType& type = core.tables.atom_type(atom);
  if (type.variables.size > kMostCompared || type.ports[transition.port].variables.size != 0) return 0;
  return type.variables.size * sizeof(Cell);
}
[[gnu::noinline]] static void copy_data(CoreParts& core, u32 atom, const LinkedTransition& transition,
                                        DataBefore& out) {
  std::memcpy(out.data(), core.memory.cells.from(core.atoms[atom].first_cell), compared_data(core, atom, transition));
}
[[gnu::noinline]] static bool has_same_data(CoreParts& core, u32 atom, const LinkedTransition& transition,
                                            const DataBefore& before) {
  const std::size_t compared = compared_data(core, atom, transition);
  return compared != 0 &&
         std::memcmp(before.data(), core.memory.cells.from(core.atoms[atom].first_cell), compared) == 0;
}

// The action, then what that changes, of a transition that needs no more. Within the loop: what the loop holds in
// registers is loaded once for all ports.
[[gnu::always_inline]] inline bool AtomSteps::move_and_look(u32 atom, const AtomInfo& info,
                                                            const LinkedTransition& transition) {
  BIP_ASSERT(core_.memory.places[atom] == transition.from, "atom {} is at place {}", atom, core_.memory.places[atom]);
  core_.memory.places[atom] = transition.to;
  Cell* const all = core_.memory.cells.all();
  Cell* const own = core_.memory.cells.from(info.first_cell);
  if (transition.action.fn != nullptr) {
    const std::int32_t status = transition.action.fn(transition.action.context, own, all, nullptr);
    if (status >= 2) [[unlikely]]
      return core_.faults.fail_code(status, atom, kNone, transition.source);
  }
  const PortDelta* delta = core_.tables.deltas.data() + transition.delta_first;
  for (const PortDelta* const end = delta + transition.delta_count; delta != end; ++delta) {
    const u32 instance = info.port_base + delta->port;
    if (transition.settling == Settling::Flips ? true : core_.ports.exchange(instance, delta->transition))
      core_.ports.flip(instance, delta->transition != kNone);
  }
  const GuardedPort* port = core_.tables.guarded_ports.data() + transition.guarded_first;
  for (const GuardedPort* const end = port + transition.guarded_count; port != end; ++port) {
    const std::int32_t status = port->guard.fn(port->guard.context, own, all, nullptr);
    BIP_ASSERT(status >= 0, "a guard of atom {} returns {}", atom, status);
    if (status >= 2) [[unlikely]]
      return core_.faults.fail_code(status, atom, kNone, core_.tables.transitions[port->transition].source);
    const u32 instance = info.port_base + port->port;
    // Mostly it is as it was.
    if (core_.ports.exchange(instance, status != 0 ? port->transition : kNone)) flip_port(instance, status != 0);
  }
  return true;
}

[[gnu::noinline]] void AtomSteps::flip_port(u32 instance, bool on) { core_.ports.flip(instance, on); }

bool AtomSteps::fire_port(u32 instance) { return fire_ports({&instance, 1}); }

bool AtomSteps::fire_ports(Span<u32> ports) {
  // An atom whose part of a step is in progress is busy, even if that changes nothing.
  if (core_.partial.is_beginning()) [[unlikely]] {
    return std::all_of(ports.begin(), ports.end(), [&](u32 instance) { return core_.partial.begin_port(instance); });
  }
  const u64* const idle = core_.tables.idle_ports.empty() ? nullptr : core_.tables.idle_ports.data();
  for (const u32 instance : ports) {
    if (idle != nullptr && (idle[instance >> 6] >> (instance & 63) & 1) != 0) continue;
    BIP_ASSERT(core_.ports.port(instance).transition != kNone, "port {} is disabled", instance);
    const LinkedTransition& transition = core_.tables.transitions[core_.ports.port(instance).transition];
    // Its data stay as they are: nothing that reads them is to be evaluated again.
    if (transition.settling == Settling::Nothing) continue;
    const u32 atom = core_.tables.port_atom[instance];
    const AtomInfo& info = core_.atoms[atom];
    BIP_ASSERT(transition.port == instance - info.port_base, "the transition of port {} is of port {}", instance,
               transition.port);
    if (transition.settling == Settling::All || info.watched == kWatchedByData) [[unlikely]] {
      if (!fire_and_settle(atom, transition)) return false;
      continue;
    }
    if (!move_and_look(atom, info, transition)) return false;
    if (info.watched != 0) core_.ports.touch(atom);
  }
  return true;
}

// What reads the data of the atom is evaluated again only if they have changed.
[[gnu::noinline]] bool AtomSteps::fire_and_settle(u32 atom, const LinkedTransition& transition) {
  const AtomInfo& info = core_.atoms[atom];
  const LinkedType& type = core_.tables.types[info.type];
  const u32 before = core_.memory.places[atom];
  // With time: else there is nothing to settle.
  if (transition.is_idle) return core_.clocks.begin_resume(atom, &transition);
  if (type.is_timed && core_.actions.any()) {
    if (const Async* async = core_.actions.async_of(atom, transition))
      return core_.actions.begin_action(atom, transition, *async);
  }
  DataBefore data_before;
  if (info.watched == kWatchedByData) copy_data(core_, atom, transition, data_before);
  if (transition.settling != Settling::All) {
    if (!move_and_look(atom, info, transition)) return false;
  } else if (!move(atom, transition) || (type.has_invariants && !check_invariants(atom, &transition)) ||
             !settle_atom(atom, before, &transition)) {
    return false;
  }
  if (info.watched == kWatchedByData && has_same_data(core_, atom, transition, data_before)) return true;
  if (info.watched != 0) core_.ports.touch(atom);
  return true;
}

bool AtomSteps::is_in_scope(u32 atom, const Invariant& invariant) const {
  if (invariant.scope == InvariantScope::Always) return true;
  if (!std::all_of(invariant.places.begin(), invariant.places.end(),
                   [&](u32 place) { return core_.is_marked(atom, place); }))
    return false;
  if (invariant.scope == InvariantScope::From) return true;
  u32 marked = 0;
  for (u32 place = 0; place < core_.tables.atom_type(atom).places.size; ++place)
    marked += core_.is_marked(atom, place) ? 1u : 0u;
  return marked == invariant.places.size;
}

bool AtomSteps::check_invariants(u32 atom, const LinkedTransition* fired) {
  const AtomType& type = core_.tables.atom_type(atom);
  const Transition* transition = fired == nullptr ? nullptr : fired->source;
  for (const Invariant& invariant : type.invariants) {
    if (!is_in_scope(atom, invariant)) continue;
    const Code condition = core_.tables.code(invariant.condition);
    if (condition.fn == nullptr) continue;
    const std::int32_t status = condition.fn(condition.context, core_.memory.cells.from(core_.atoms[atom].first_cell),
                                             core_.memory.cells.all(), nullptr);
    if (status >= 2) return core_.faults.fail_code(status, atom, kNone, transition, invariant.name);
    if (status == 0) return core_.faults.fail_invariant(atom, invariant, transition);
  }
  return true;
}

}  // namespace bip::rt
