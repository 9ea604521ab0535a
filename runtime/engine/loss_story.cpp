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

bool is_whole(const Distribution& distribution, const std::vector<bool>& is_lost, u32 set) {
  const Span<u32> atoms = distribution.sets.atoms[set];
  return !is_lost[distribution.coordinator[set]] &&
         std::none_of(atoms.begin(), atoms.end(), [&](u32 atom) { return is_lost[distribution.home(atom)]; });
}

// Whatever it did last, where that tells its set.
static bool waits_for_lost(const Distribution& distribution, const std::vector<bool>& is_lost, u32 atom, u32 place) {
  const ConflictSets& sets = distribution.sets;
  if (sets.by_situation[atom] == 0) {
    const u32 set = sets.set_of(atom, place);
    return set != kNone && !is_whole(distribution, is_lost, set);
  }
  const auto is_before = [](const ConflictSets::Situation& at, const std::pair<u32, u32>& key) {
    return std::pair(at.atom, at.place) < key;
  };
  auto at = std::lower_bound(sets.situations.begin(), sets.situations.end(), std::pair(atom, place), is_before);
  bool is_any = false;
  for (; at != sets.situations.end() && at->atom == atom && at->place == place; ++at) {
    if (is_whole(distribution, is_lost, at->set)) return false;
    is_any = true;
  }
  return is_any;
}

std::string loss_story(const Core& core, const Distribution& distribution, const std::vector<bool>& is_lost, u64 steps,
                       const std::string& why) {
  std::vector<u32> gone, waiting;
  for (u32 atom = 0; atom < core.image().atoms.size; ++atom) {
    if (is_lost[distribution.home(atom)]) {
      gone.push_back(atom);
      continue;
    }
    if (waits_for_lost(distribution, is_lost, atom, core.partial().place_at_rest(atom))) waiting.push_back(atom);
  }
  std::string names;
  for (u32 node = 0; node < is_lost.size(); ++node) {
    if (is_lost[node]) names += (names.empty() ? "`" : ", `") + distribution.placement.nodes[node] + '`';
  }
  std::string text = "lost " + names + " after " + std::to_string(steps) + " steps" + why + "\n  at home there: ";
  name_atoms(text, core, gone);
  text += "  waiting for it: ";
  name_atoms(text, core, waiting);
  return text;
}

}  // namespace bip::rt
