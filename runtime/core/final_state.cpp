// See final_state.hpp.
#include "runtime/core/final_state.hpp"

#include <algorithm>

#include "runtime/core/deadlock_explanation.hpp"
#include "runtime/core/text.hpp"

namespace bip::rt {

bool has_final_states(const Image& image) {
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    if (image.atom_types[image.atoms[atom].type].final_places.size == 0) return false;
  }
  return true;
}

bool is_at_final_places(const Core& core, u32 atom) {
  const AtomType& type = core.image().atom_types[core.image().atoms[atom].type];
  const Span<u32>& finals = type.final_places;
  if (finals.size == 0) return false;
  for (u32 place = 0; place < type.places.size; ++place) {
    if (core.is_marked(atom, place) && !std::binary_search(finals.begin(), finals.end(), place)) return false;
  }
  return true;
}

bool wants_to_move(const Core& core, u32 atom) {
  if (is_at_final_places(core, atom)) return false;
  const Image& image = core.image();
  for (u32 port = 0; port < image.atom_types[image.atoms[atom].type].ports.size; ++port) {
    if (core.enabled_transition(atom, port) != kNone) return true;
  }
  return false;
}

bool is_final_state(const Core& core) {
  for (u32 atom = 0; atom < core.image().atoms.size; ++atom) {
    if (!is_at_final_places(core, atom)) return false;
  }
  return true;
}

std::string end_story(const Core& core, std::uint64_t steps, std::uint64_t seed) {
  return is_final_state(core) ? final_line(steps, seed) : deadlock_story(core, steps, seed);
}

std::string final_line(std::uint64_t steps, std::uint64_t seed) {
  std::string line = "final: each component is at a final place   (";
  append_number(line, steps);
  line += steps == 1 ? " step, seed " : " steps, seed ";
  append_number(line, seed);
  return line + ")\n";
}

}  // namespace bip::rt
