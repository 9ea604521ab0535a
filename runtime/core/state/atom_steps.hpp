// Atoms one by one: firing a port's transition, internal transitions, invariants, and what the ports offer afterwards.
//
// A local type is an automaton of which places and guards alone say what it offers: each of its transitions lists the
// ports whose enabled transition changes for sure, and the guards that decide about the rest; in a simple one a port is
// enabled iff the atom is at its place. Others evaluate the guards of all transitions that leave what is marked.
// Functions return false after a fault.
#pragma once
#include <vector>

#include "runtime/core/link/tables.hpp"

namespace bip::rt {

struct CoreParts;

class AtomSteps {
 public:
  explicit AtomSteps(CoreParts& core) : core_(core) {}
  void link();

  /// Fires the transition that the port has enabled, and what follows in the atom; its ports are up to date then.
  bool fire_port(u32 instance);
  /// The same of ports of different atoms, one after the other.
  bool fire_ports(Span<u32> ports);
  /// Runs internal transitions as long as there are, then updates the ports. fired: null after `initial`.
  bool settle_atom(u32 atom, u32 place_before, const LinkedTransition* fired);
  /// Finds the enabled transition of each port anew. place_before: kNone if not known.
  bool update_ports(u32 atom, u32 place_before);
  /// Finds the enabled transition of each port, into port_scratch(): kNone if there is none. Its ports stay as they
  /// are.
  bool find_ports(u32 atom);
  /// Finds the enabled internal transition; null if none is.
  bool find_internal(u32 atom, const LinkedTransition*& found);
  bool move_tokens(u32 atom, const LinkedTransition& transition);
  /// Are the transition's places marked (of Petri types), and does its guard hold?
  bool is_enabled_from(u32 atom, const LinkedTransition& transition, bool& enabled);
  /// Checks the invariants in scope. fired: null after `initial`.
  bool check_invariants(u32 atom, const LinkedTransition* fired);
  /// Does the invariant apply to the marking?
  [[nodiscard]] bool is_in_scope(u32 atom, const Invariant& invariant) const;

  /// Scratch for a transition by port of one atom: as many words as the largest type has ports.
  [[nodiscard]] u32* port_scratch() { return port_scratch_.data(); }

 private:
  bool look_at(u32 atom, u32 row);
  bool move_and_look(u32 atom, const AtomInfo& info, const LinkedTransition& transition);
  void flip_port(u32 instance, bool on);
  bool fire_and_settle(u32 atom, const LinkedTransition& transition);
  bool run_internals(u32 atom);
  bool move(u32 atom, const LinkedTransition& transition);

  CoreParts& core_;
  std::vector<u32> port_scratch_;
};

}  // namespace bip::rt
