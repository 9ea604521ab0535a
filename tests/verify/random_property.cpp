// See random_property.hpp.
#include "tests/verify/random_property.hpp"

#include "tools/gen/random.hpp"

namespace bip::verify::test {

std::string random_property(const System& system, std::uint64_t seed) {
  gen::Prng random(seed);
  std::string text = "never ";
  for (int k = 0; k < 2; ++k) {
    const Atom& atom = system.atoms[AtomId(static_cast<std::size_t>(random.below(system.atoms.size())))];
    const AtomType& type = system.atom_types[atom.type];
    if (k != 0) text += " && ";
    const std::string path = atom.path.substr(5);
    if (!type.variables.empty() && random.below(3) == 0) {
      const DataVariable& variable = type.variables[static_cast<std::size_t>(random.below(type.variables.size()))];
      if (variable.type == Type::Int) {
        text += path + '.' + variable.name + " > " + std::to_string(random.below(4));
        continue;
      }
      if (variable.type == Type::Bool) {
        text += path + '.' + variable.name;
        continue;
      }
    }
    text += path + '@' + type.places[static_cast<std::size_t>(random.below(type.places.size()))];
  }
  return text;
}

}  // namespace bip::verify::test
