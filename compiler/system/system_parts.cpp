// See system_parts.hpp.
#include "compiler/system/system_parts.hpp"

#include "compiler/system/system.hpp"

namespace bip::system {

std::size_t atom_count(const System& system) { return system.atoms.size(); }
std::size_t connector_count(const System& system) { return system.connectors.size(); }
const std::string& atom_path(const System& system, std::size_t row) { return system.atoms[AtomId(row)].path; }
const std::string& connector_path(const System& system, std::size_t row) {
  return system.connectors[ConnectorId(row)].path;
}
const AtomType& type_of_atom(const System& system, std::size_t row) {
  return system.atom_types[system.atoms[AtomId(row)].type];
}
const std::vector<AtomType>& atom_types(const System& system) { return system.atom_types.rows(); }
void release_instances(System& system) {
  system.atoms = {};
  system.connectors = {};
}

}  // namespace bip::system
