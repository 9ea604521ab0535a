// See event_classes.hpp. Linear in the types and atoms.
#include "compiler/lower/event_classes.hpp"

#include "compiler/system/system.hpp"

namespace bip::lower {

std::vector<EventClassUse> event_class_uses(const System& system) {
  std::vector<EventClassUse> uses;
  if (system.code.cpp.includes.empty()) return uses;
  std::vector<bool> has_instance(system.atom_types.size());
  for (const Atom& atom : system.atoms) has_instance[atom.type.value] = true;
  for (std::uint32_t row = 0; row < system.atom_types.size(); ++row) {
    const AtomType& type = system.atom_types[AtomTypeId(row)];
    for (std::uint32_t port = 0; has_instance[row] && port < type.ports.size(); ++port) {
      if (type.ports[port].external && !type.ports[port].event_class.empty()) uses.push_back({AtomTypeId(row), port});
    }
  }
  return uses;
}

}  // namespace bip::lower
