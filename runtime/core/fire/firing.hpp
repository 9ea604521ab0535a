// Firing an interaction port by port: `up` again for the chosen configuration (frames may be stale), then from the top
// connector `down` and the ports in parameter order, depth first; an atom's port takes its recorded transition, its
// guard is not evaluated again.
//
// Cost: what takes part. A flat rendezvous is a loop over port instances. Steps whose effect is always the same have a
// shorter way: programs/step_programs.hpp.
#pragma once
#include <utility>
#include <vector>

#include "runtime/core/link/tables.hpp"
#include "runtime/core/state/enabled_set.hpp"
#include "runtime/core/state/state.hpp"

namespace bip::rt {

struct CoreParts;

class Firing {
 public:
  explicit Firing(CoreParts& core) : core_(core) {}

  /// Takes the step, by its program if it has one; the core is settled then. False: a fault.
  bool fire(const Candidate& candidate);
  /// The same of a candidate whose ports() are known, while no steps are in progress.
  bool fire(const Candidate& candidate, Span<u32> ports);
  /// fire(candidate(at)) by the shortest way, while no steps are in progress.
  bool take(EnabledSet::Position at);
  /// Takes the step port by port.
  bool fire_parts(const Candidate& candidate);
  /// Fires all ports of a flat rendezvous, without settling.
  bool fire_flat(const InteractionInfo& info);

  /// Finds the atom ports that take part, in the order in which they fire.
  void participants(const Candidate& candidate, std::vector<Participant>& out);
  /// Returns the instances of the atom ports that take part, in the order in which they fire; valid up to the next
  /// call. Where a connector chooses among its ports, those of its last choices are kept: nearly always it is one of
  /// them again.
  Span<u32> ports(const Candidate& candidate);
  /// Finds the ports of the connector itself; exported ports of connectors below as such, with this candidate's values:
  /// runs `up`.
  void direct_participants(const Candidate& candidate, std::vector<Participant>& out);

  /// Runs code of a connector over its frame. False: a fault.
  bool run_code(Code code, u32 connector);
  /// Makes the connector's own data zero.
  void zero_frame(u32 connector);

 private:
  /// What a plan chose when its ports were last listed: a system goes around in few of its choices. The key is
  /// InteractionSearch::choice_key, ports are instances.
  struct ListedChoice {
    std::vector<u64> key;
    std::vector<u32> ports;
  };
  struct ListedChoices {
    std::vector<ListedChoice> choices;  // at most kListedChoices
    u32 next = 0;                       // is replaced next
  };
  static constexpr u32 kListedChoices = 4;

  /// Calls visit(parameter, instance) for each atom port of the configuration that the search has chosen.
  template <class Visit>
  void visit_chosen(const Plan& plan, const Visit& visit);
  bool fire_rigid(const Plan& plan);
  bool fire_star(const InteractionInfo& info);
  /// ports() of a planned interaction.
  Span<u32> planned_ports(const Candidate& candidate, const InteractionInfo& info);
  Span<u32> list_choices(const Plan& plan);
  bool fire_planned(const Candidate& candidate, const InteractionInfo& info);
  bool run_transfer(const InteractionInfo& info, u32 clause);

  CoreParts& core_;
  std::vector<u32> params_;                     // scratch
  std::vector<std::pair<u32, u32>> use_stack_;  // scratch
  std::vector<u32> ports_;                      // scratch
  std::vector<ListedChoices> choices_;          // by plan, once the ports of one are asked for
};

}  // namespace bip::rt
