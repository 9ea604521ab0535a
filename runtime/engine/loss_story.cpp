// See loss_story.hpp.
#include "runtime/engine/loss_story.hpp"

#include <algorithm>
#include <utility>

namespace bip::rt {

namespace {

constexpr std::size_t kMostNamed = 5;

void name_atoms(std::string& text, const Core& core, const std::vector<u32>& atoms) {
  if (atoms.empty()) text += "none";
  for (std::size_t i = 0; i < std::min(atoms.size(), kMostNamed); ++i)
    text += (i == 0 ? "" : ", ") + core.image().atoms[atoms[i]].path();
  if (atoms.size() > kMostNamed) text += " and " + std::to_string(atoms.size() - kMostNamed) + " more";
  text += '\n';
}

}  // namespace

Survivors::Survivors(const Core& core, const Distribution& distribution, std::vector<bool> is_lost)
    : core_(core), is_lost_(std::move(is_lost)) {
  const Tables& tables = core.tables();
  const PartialState partial = link_partial(tables, core.priorities());
  const auto is_gone = [&](u32 atom) { return is_lost_[distribution.home(atom)]; };
  std::vector<bool> is_group_lost(partial.busy_in_group.size(), false);
  for (u32 atom = 0; atom < core.image().atoms.size; ++atom) {
    for (const u32 group : partial.groups_of_atom[atom]) {
      if (is_gone(atom)) is_group_lost[group] = true;
    }
  }
  for (const InteractionId interaction : tables.interactions.ids()) {
    const Span<u32> atoms = partial.atoms_of_interaction[interaction];
    const Span<u32> groups = partial.groups_of_interaction[interaction];
    is_whole_.push(!is_lost_[distribution.coordinator_of[interaction]] &&
                   std::none_of(atoms.begin(), atoms.end(), is_gone) &&
                   std::none_of(groups.begin(), groups.end(), [&](u32 group) { return is_group_lost[group]; }));
  }
  interactions_of_atom_ = partial.atoms_of_interaction.transposed(core.image().atoms.size);
}

bool Survivors::may_wait(u32 atom) const {
  const Span<InteractionId> interactions = interactions_of_atom_[atom];
  return std::any_of(interactions.begin(), interactions.end(),
                     [&](InteractionId interaction) { return !is_whole(interaction); });
}

bool Survivors::waits(u32 atom, u32 place) const {
  const Tables& tables = core_.tables();
  const LinkedType& type = tables.types[tables.atoms[atom].type];
  const auto leaves = [&](u32 port) {
    if (tables.port_atom[port] != atom) return false;
    for (u32 row = type.first_transition; row < type.first_transition + type.transition_count; ++row) {
      const LinkedTransition& transition = tables.transitions[row];
      if (transition.port == port - tables.port_base(atom) && (type.mark_words != 0 || transition.from == place))
        return true;
    }
    return false;
  };
  bool is_any = false;
  std::vector<u32> ports;
  for (const InteractionId interaction : interactions_of_atom_[atom]) {
    ports_of_interaction(tables, tables.interactions[interaction], ports);
    if (std::none_of(ports.begin(), ports.end(), leaves)) continue;
    if (is_whole(interaction)) return false;
    is_any = true;
  }
  return is_any;
}

std::string loss_story(const Core& core, const Distribution& distribution, const Survivors& survivors,
                       const std::vector<bool>& locked, u64 steps, const std::string& why) {
  std::vector<u32> gone, waiting;
  for (u32 atom = 0; atom < core.image().atoms.size; ++atom) {
    if (survivors.is_lost(distribution.home(atom))) {
      gone.push_back(atom);
      continue;
    }
    const bool is_locked = !locked.empty() && locked[atom];
    if (is_locked || survivors.waits(atom, core.partial().place_at_rest(atom))) waiting.push_back(atom);
  }
  std::string names;
  for (u32 node = 0; node < distribution.placement.nodes.size(); ++node) {
    if (survivors.is_lost(node)) names += (names.empty() ? "`" : ", `") + distribution.placement.nodes[node] + '`';
  }
  std::string text = "lost " + names + " after " + std::to_string(steps) + " steps" + why + "\n  at home there: ";
  name_atoms(text, core, gone);
  text += "  waiting for it: ";
  name_atoms(text, core, waiting);
  return text;
}

std::string silence_story(const Core& core, const Distribution& distribution, u32 node) {
  std::vector<bool> is_silent(distribution.placement.nodes.size(), false);
  is_silent[node] = true;
  const Survivors others(core, distribution, std::move(is_silent));
  std::vector<u32> there, waiting;
  for (u32 atom = 0; atom < core.image().atoms.size; ++atom) {
    if (distribution.home(atom) == node) there.push_back(atom);
    else if (others.may_wait(atom)) waiting.push_back(atom);
  }
  std::string text = "  at home there: ";
  name_atoms(text, core, there);
  text += "  may wait for it: ";
  name_atoms(text, core, waiting);
  return text;
}

}  // namespace bip::rt
