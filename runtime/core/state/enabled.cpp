// What an atom offers, and how a port that becomes enabled or disabled spreads through the connectors.
//
// A fixed type (no guards, no internal transitions) needs no evaluation: each of its transitions has the list of ports
// whose enabled transition changes; in a simple one a port is enabled iff the atom is at its place. Others evaluate the
// guards of the transitions that leave what is marked. A flip walks the availability network as long as counters cross
// zero: O(depth), and O(1) in a flat connector.
#include "runtime/core/state/flip.hpp"

namespace bip::rt {

void Core::mark_dirty(u32 interaction) {
  if (is_dirty_[interaction] != 0) return;
  is_dirty_[interaction] = 1;
  dirty_.push_back(interaction);
}

void Core::crossed(u32 node, bool on) {
  const u32 cell_count = static_cast<u32>(tables_.interactions.size());
  if (node < cell_count) {
    if (!direct_.has(node)) {
      mark_dirty(node);
    } else if (tables_.any_searched) {
      enabled_.set(node, on ? 1 : 0);
    } else if (on) {
      enabled_.insert(node);
    } else {
      enabled_.erase(node);
    }
    return;
  }
  // Inner groups: iterative, for the hierarchy may be deep. Each crossing moves every counter above by one, so the
  // order in which crossings are worked off does not matter.
  crossings_.emplace_back(node, on);
  const std::size_t bottom = crossings_.size() - 1;
  while (crossings_.size() > bottom) {
    const auto [from, now] = crossings_.back();
    crossings_.pop_back();
    for (u32 above : tables_.node_out[from]) {
      const bool crosses = now ? ++values_[above] == 0 : values_[above]-- == 0;
      if (!crosses) continue;
      if (above < cell_count) crossed(above, now);
      else crossings_.emplace_back(above, now);
    }
  }
}

void Core::touch(u32 atom) {
  const u32 cell_count = static_cast<u32>(tables_.interactions.size());
  for (u32 item : tables_.atom_watch[atom]) {
    if (item < cell_count) {
      // What is not available has nothing to evaluate; becoming available marks it.
      if (values_[item] >= 0) mark_dirty(item);
    } else if (is_rule_dirty_[item - cell_count] == 0) {
      is_rule_dirty_[item - cell_count] = 1;
      dirty_rules_.push_back(item - cell_count);
    }
  }
}

bool Core::is_enabled_from(u32 atom, const LinkedTransition& transition, bool& enabled) {
  const AtomInfo& state = atoms_[atom];
  enabled = true;
  if (transition.from == kNone) {
    for (u32 place : transition.source->from) {
      if (!is_marked(atom, place)) {
        enabled = false;
        return true;
      }
    }
  }
  if (transition.guard.fn == nullptr) return true;
  const std::int32_t status =
      transition.guard.fn(transition.guard.context, all_.data() + state.first_cell, all_.data(), nullptr);
  if (status >= 2) return fail_code(status, atom, kNone, transition.source);
  enabled = status != 0;
  return true;
}

bool Core::move_tokens(u32 atom, const LinkedTransition& transition) {
  if (transition.to != kNone) {
    places_[atom] = transition.to;
  } else {
    u64* marks = marks_.data() + tables_.first_mark(atom);
    for (u32 place : transition.source->from) marks[place >> 6] &= ~(u64{1} << (place & 63));
    for (u32 place : transition.source->to) {
      const u64 bit = u64{1} << (place & 63);
      if ((marks[place >> 6] & bit) != 0) return fail(FaultCode::NotOneSafe, atom, transition.source, nullptr);
      marks[place >> 6] |= bit;
    }
  }
  return true;
}

// Tokens, then the action.
inline bool Core::move(u32 atom, const LinkedTransition& transition) {
  const AtomInfo& state = atoms_[atom];
  if (transition.to != kNone) places_[atom] = transition.to;
  else if (!move_tokens(atom, transition)) return false;
  if (transition.action.fn != nullptr) {
    const std::int32_t status =
        transition.action.fn(transition.action.context, all_.data() + state.first_cell, all_.data(), nullptr);
    if (status >= 2) return fail_code(status, atom, kNone, transition.source);
    if (time_ != nullptr && !read_clocks(atom, transition.source)) return false;
  }
  return true;
}

// The internal transition that is enabled, null if none is.
bool Core::find_internal(u32 atom, const LinkedTransition*& found) {
  const LinkedType& type = tables_.types[atoms_[atom].type];
  found = nullptr;
  const auto look = [&](const LinkedTransition& transition) {
    bool enabled = false;
    if (!is_enabled_from(atom, transition, enabled)) return false;
    if (!enabled) return true;
    if (found != nullptr) return fail(FaultCode::TwoInternals, atom, found->source, transition.source);
    found = &transition;
    return true;
  };
  if (type.mark_words == 0) {
    for (u32 row : tables_.place_internals[type.first_place + places_[atom]]) {
      if (!look(tables_.transitions[row])) return false;
    }
    return true;
  }
  for (u32 i = 0; i < type.transition_count; ++i) {
    const LinkedTransition& transition = tables_.transitions[type.first_transition + i];
    if (transition.port == kNone && !look(transition)) return false;
  }
  return true;
}

bool Core::run_internals(u32 atom) {
  const LinkedType& type = tables_.types[atoms_[atom].type];
  for (std::uint32_t run = 0;; ++run) {
    const LinkedTransition* found = nullptr;
    if (!find_internal(atom, found)) return false;
    if (found == nullptr) return true;
    if (run >= options_.internal_bound) return fail(FaultCode::EndlessInternals, atom, found->source, nullptr);
    if (!move(atom, *found)) return false;
    if (type.has_invariants && !check_invariants(atom, found)) return false;
  }
}

bool Core::update_ports(u32 atom, u32 place_before) {
  const AtomInfo& state = atoms_[atom];
  const LinkedType& type = tables_.types[state.type];
  const u32 place_now = places_[atom];
  if (type.simple) {
    if (place_before == place_now) return true;
    if (place_before != kNone) {
      for (u32 row : tables_.place_transitions[type.first_place + place_before]) {
        flip(state.port_base + tables_.transitions[row].port, false);
      }
    }
    for (u32 row : tables_.place_transitions[type.first_place + place_now]) {
      flip(state.port_base + tables_.transitions[row].port, true);
    }
    return true;
  }
  if (type.is_timed) return look_at_time(atom);
  u32* now = port_scratch_.data();
  const auto look = [&](u32 row) {
    const LinkedTransition& transition = tables_.transitions[row];
    bool enabled = false;
    if (!is_enabled_from(atom, transition, enabled)) return false;
    if (!enabled) return true;
    u32& interaction = now[transition.port];
    if (interaction != kNone) {
      return fail(FaultCode::TwoTransitions, atom, tables_.transitions[interaction].source, transition.source);
    }
    interaction = row;
    return true;
  };
  if (type.mark_words == 0 && place_before != kNone && !type.has_priorities) {
    // Only ports that the two places offer can change.
    const Span<u32> old_rows = tables_.place_transitions[type.first_place + place_before];
    const Span<u32> rows = tables_.place_transitions[type.first_place + place_now];
    for (u32 row : rows) now[tables_.transitions[row].port] = kNone;
    if (place_before != place_now) {
      for (u32 row : old_rows) now[tables_.transitions[row].port] = kNone;
    }
    for (u32 row : rows) {
      if (!look(row)) return false;
    }
    if (place_before != place_now) {
      for (u32 row : old_rows) {
        const u32 port = tables_.transitions[row].port;
        set_port(state.port_base + port, now[port]);
      }
    }
    for (u32 row : rows) {
      const u32 port = tables_.transitions[row].port;
      set_port(state.port_base + port, now[port]);
    }
    return true;
  }
  const u32 ports = tables_.port_base(atom + 1) - state.port_base;
  for (u32 port = 0; port < ports; ++port) now[port] = kNone;
  if (type.mark_words == 0) {
    for (u32 row : tables_.place_transitions[type.first_place + place_now]) {
      if (!look(row)) return false;
    }
  } else {
    for (u32 i = 0; i < type.transition_count; ++i) {
      if (tables_.transitions[type.first_transition + i].port == kNone) continue;
      if (!look(type.first_transition + i)) return false;
    }
  }
  if (type.has_priorities && !hide_ports(atom, now)) return false;
  for (u32 port = 0; port < ports; ++port) set_port(state.port_base + port, now[port]);
  return true;
}

// fired: null for `initial`.
bool Core::settle_atom(u32 atom, u32 place_before, const LinkedTransition* fired) {
  const LinkedType& type = tables_.types[atoms_[atom].type];
  if (type.has_internal && !run_internals(atom)) return false;
  if (type.is_timed) return begin_resume(atom, fired) && look_at_time(atom);
  return update_ports(atom, place_before);
}

bool Core::fire_port(u32 instance) {
  if (collects_) return begin_port(instance);
  const PortState& port = ports_[instance];
  const u32 atom = tables_.port_atom[instance];
  const AtomInfo& info = atoms_[atom];
  const LinkedType& type = tables_.types[info.type];
  const LinkedTransition& transition = tables_.transitions[port.transition];
  const u32 before = places_[atom];
  if (type.is_timed && !time_->at_work.empty()) {
    if (const Async* async = async_of(atom, transition)) return begin_action(atom, transition, *async);
  }
  if (!move(atom, transition)) return false;
  if (type.fixed) {
    const PortDelta* delta = tables_.deltas.data() + transition.delta_first;
    if (type.simple) {
      for (u32 i = 0; i < transition.delta_count; ++i)
        flip(info.port_base + delta[i].port, delta[i].transition != kNone);
    } else {
      for (u32 i = 0; i < transition.delta_count; ++i) set_port(info.port_base + delta[i].port, delta[i].transition);
    }
  } else if ((type.has_invariants && !check_invariants(atom, &transition)) || !settle_atom(atom, before, &transition)) {
    return false;
  }
  if (info.watched != 0) touch(atom);
  return true;
}

}  // namespace bip::rt
