// See loss_story.hpp.
#include "runtime/engine/loss_story.hpp"

#include <algorithm>

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

std::string loss_story(const Core& core, const Distribution& distribution, const std::vector<bool>& is_lost, u64 steps,
                       const std::string& why) {
  std::vector<u32> gone, waiting;
  for (u32 atom = 0; atom < core.image().atoms.size; ++atom) {
    if (is_lost[distribution.home(atom)]) {
      gone.push_back(atom);
      continue;
    }
    const u32 set = distribution.sets.set_of(atom, core.partial().place_at_rest(atom));
    if (set != kNone && !is_whole(distribution, is_lost, set)) waiting.push_back(atom);
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
