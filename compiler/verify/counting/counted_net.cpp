// See counted_net.hpp. Local states that a step leads to are combined with all others in turn, until none is new: a
// least fixpoint, in which every combination of local states that occur counts as possible.
#include "compiler/verify/counting/counted_net.hpp"

#include <algorithm>
#include <map>
#include <tuple>
#include <set>

#include "compiler/base/log.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// Combinations between two looks at the clock.
constexpr u32 kBetweenLooks = 256;

}  // namespace

CountedNetBuilder::CountedNetBuilder(const rt::Image& image, const InterchangeableGroups& groups,
                                     const std::vector<rt::VariableId>& unread_cells)
    : image_(image),
      core_(image),
      is_initial_sound_(core_.initialize()),
      locals_(core_, unread_cells),
      shapes_(rt::shapes_of(core_, rt::MaximalProgress::On)) {
  if (!is_initial_sound_) return;
  scratch_ = core_.snapshot();
  net_.kind_of_atom.assign(image.atoms.size, CountedNet::kNone);
  for (const auto& group : groups) {
    for (std::size_t column = 0; column < group.front().size(); ++column) {
      const u32 kind = static_cast<u32>(net_.atom_of_kind.size());
      net_.atom_of_kind.push_back(group.front()[column]);
      for (const std::vector<u32>& member : group) {
        BIP_ASSERT(locals_.class_of(member[column]) == locals_.class_of(group.front()[column]),
                   "atoms {} and {} are not alike", member[column], group.front()[column]);
        net_.kind_of_atom[member[column]] = kind;
      }
    }
  }
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    if (net_.kind_of_atom[atom] != CountedNet::kNone) continue;
    net_.kind_of_atom[atom] = static_cast<u32>(net_.atom_of_kind.size());
    net_.atom_of_kind.push_back(atom);
  }
  net_.places_of_kind.resize(net_.atom_of_kind.size());
  place_by_local_.resize(net_.atom_of_kind.size());
  choose_interactions(groups);
}

// Any so many members of a group are mapped to its first ones by some permutation, with the interactions that they
// have.
void CountedNetBuilder::choose_interactions(const InterchangeableGroups& groups) {
  std::map<u32, std::pair<std::size_t, std::size_t>> member_of;  // by atom: group, member
  for (std::size_t group = 0; group < groups.size(); ++group) {
    for (std::size_t member = 0; member < groups[group].size(); ++member) {
      for (const u32 atom : groups[group][member]) member_of[atom] = {group, member};
    }
  }
  for (const rt::InteractionId interaction : shapes_.interactions.ids()) {
    std::map<std::size_t, std::set<std::size_t>> members;
    std::vector<u32> single, like;
    for (const u32 atom : shapes_.atoms_of(interaction)) {
      const auto found = member_of.find(atom);
      (found == member_of.end() ? single : like).push_back(atom);
      if (found != member_of.end()) members[found->second.first].insert(found->second.second);
    }
    const auto are_first = [](const auto& row) { return *row.second.rbegin() + 1 == row.second.size(); };
    if (!std::all_of(members.begin(), members.end(), are_first)) continue;
    // What many connectors watch changes least often.
    single.insert(single.end(), like.begin(), like.end());
    std::vector<std::size_t> explored(single.size(), 0);
    tabulated_.push_back({interaction, std::move(single), std::move(explored)});
  }
}

bool CountedNetBuilder::give_up(const std::string& problem) {
  if (net_.problem.empty()) net_.problem = problem;
  return false;
}

bool CountedNetBuilder::enter_atoms(const std::vector<u32>& atoms, const std::vector<u32>& places) {
  BIP_ASSERT(atoms.size() == places.size(), "{} atoms, {} places", atoms.size(), places.size());
  for (std::size_t k = 0; k < atoms.size(); ++k) write(atoms[k], places[k]);
  const bool is_sound = core_.restore_atoms(scratch_);
  for (const u32 atom : atoms) locals_.write(atom, initial_[atom], scratch_);
  return is_sound;
}

u32 CountedNetBuilder::place_of(u32 kind, u32 local) {
  std::vector<u32>& places = place_by_local_[kind];
  if (places.size() <= local) places.resize(local + 1, CountedNet::kNone);
  if (places[local] != CountedNet::kNone) return places[local];
  const u32 place = places[local] = static_cast<u32>(net_.places.size());
  net_.places.push_back({kind, local});
  net_.places_of_kind[kind].push_back(place);
  net_.tokens.push_back(0);
  return place;
}

bool CountedNetBuilder::is_offered(u32 place, u32 port) const {
  BIP_ASSERT(place < offered_.size() && port < offered_[place].size(), "port {} at place {}", port, place);
  return offered_[place][port] != 0;
}

void CountedNetBuilder::build(const CountedNetLimits& limits) {
  if (!is_initial_sound_) {
    give_up("the initial state is none");
    return;
  }
  for (u32 atom = 0; atom < image_.atoms.size; ++atom) {
    initial_.push_back(locals_.number(atom, core_));
    const u32 kind = net_.kind_of_atom[atom];
    ++net_.tokens[place_of(kind, initial_.back())];
  }
  for (bool is_growing = true; is_growing && net_.problem.empty();) {
    is_growing = false;
    // The ports that new local states offer.
    for (u32 place = static_cast<u32>(offered_.size()); place < net_.places.size(); ++place) {
      const u32 atom = net_.atom_of_kind[net_.places[place].kind];
      if (!enter_atoms({atom}, {place})) {
        give_up("a local state ends in an error");
        return;
      }
      offered_.emplace_back();
      for (u32 port = 0; port < image_.atom_types[image_.atoms[atom].type].ports.size; ++port)
        offered_.back().push_back(core_.enabled_transition(atom, port) != rt::kNone ? 1 : 0);
    }
    for (Tabulated& row : tabulated_) {
      if (!explore(row, limits)) return;
    }
    is_growing = offered_.size() < net_.places.size();
  }
  std::sort(net_.transitions.begin(), net_.transitions.end(),
            [](const auto& a, const auto& b) { return std::tie(a.from, a.to) < std::tie(b.from, b.to); });
  const auto same = [](const auto& a, const auto& b) { return a.from == b.from && a.to == b.to; };
  net_.transitions.erase(std::unique(net_.transitions.begin(), net_.transitions.end(), same), net_.transitions.end());
  BIP_LOG(Portfolio, 1, "counted net: {} kinds, {} places, {} transitions, {} combinations", net_.atom_of_kind.size(),
          net_.places.size(), net_.transitions.size(), combinations_);
}

// All combinations that have a place which the interaction has not met: it is the first such one at `newest`.
bool CountedNetBuilder::explore(Tabulated& row, const CountedNetLimits& limits) {
  std::vector<u32> chosen(row.atoms.size());
  std::vector<std::size_t> known(row.atoms.size());
  // Places that are found now have no ports yet: they wait for the next round.
  for (std::size_t k = 0; k < row.atoms.size(); ++k) {
    const std::vector<u32>& places = net_.places_of_kind[net_.kind_of_atom[row.atoms[k]]];
    known[k] = static_cast<std::size_t>(
        std::lower_bound(places.begin(), places.end(), static_cast<u32>(offered_.size())) - places.begin());
  }
  for (std::size_t newest = 0; newest < row.atoms.size(); ++newest) {
    if (known[newest] == row.explored[newest]) continue;
    if (!combine(row, newest, 0, chosen, limits)) return false;
    // From here on the others are combined with these, too.
    row.explored[newest] = known[newest];
  }
  return true;
}

bool CountedNetBuilder::combine(Tabulated& row, std::size_t newest, std::size_t position, std::vector<u32>& chosen,
                                const CountedNetLimits& limits) {
  if (position == row.atoms.size()) return fire(row, chosen, limits);
  const u32 atom = row.atoms[position], kind = net_.kind_of_atom[atom];
  const rt::InteractionShape& shape = shapes_.interactions[row.interaction];
  // A copy of the size: steps add places.
  const std::size_t first = position == newest ? row.explored[position] : 0;
  for (std::size_t k = first; k < net_.places_of_kind[kind].size(); ++k) {
    const u32 place = net_.places_of_kind[kind][k];
    if (place >= offered_.size() || (position != newest && k >= row.explored[position])) break;
    const auto is_ready = [&](const rt::InteractionLeaf& leaf) {
      return leaf.atom != atom || is_offered(place, leaf.port);
    };
    const auto leaves = shapes_.leaves_of(row.interaction);
    if (shape.is_rendezvous && !std::all_of(leaves.begin(), leaves.end(), is_ready)) continue;
    chosen[position] = place;
    if (!combine(row, newest, position + 1, chosen, limits)) return false;
  }
  return true;
}

bool CountedNetBuilder::fire(const Tabulated& row, const std::vector<u32>& chosen, const CountedNetLimits& limits) {
  if (++combinations_ % kBetweenLooks == 0 && limits.cancellation.is_over()) return give_up("the time is over");
  for (std::size_t k = 0; k < row.atoms.size(); ++k) write(row.atoms[k], chosen[k]);
  bool is_sound = core_.restore(scratch_);
  std::uint64_t first = 0, end = 0;
  if (is_sound) {
    first = row.interaction.value == 0 ? 0 : core_.enabled().next_after(rt::InteractionId(row.interaction.value - 1));
    end = first;
    while (end < core_.candidate_count() && core_.candidate(end).interaction == row.interaction) ++end;
  }
  for (std::uint64_t candidate = first; candidate < end && is_sound; ++candidate) {
    if (candidate != first) is_sound = core_.restore(scratch_);
    is_sound = is_sound && core_.fire(candidate);
    if (!is_sound) break;
    CountedNet::Transition transition{chosen, {}};
    for (const u32 atom : row.atoms)
      transition.to.push_back(place_of(net_.kind_of_atom[atom], locals_.number(atom, core_)));
    std::sort(transition.from.begin(), transition.from.end());
    std::sort(transition.to.begin(), transition.to.end());
    if (transition.from != transition.to) net_.transitions.push_back(std::move(transition));
  }
  for (const u32 atom : row.atoms) locals_.write(atom, initial_[atom], scratch_);
  // Whether the fault is that of the interaction or that of a neighbour, which other local states would not have, is
  // not known.
  if (!is_sound) return give_up("a step may end in an error");
  if (net_.places.size() > limits.places) return give_up("too many local states");
  if (net_.transitions.size() > limits.transitions) return give_up("too many steps");
  return true;
}

}  // namespace bip::verify
