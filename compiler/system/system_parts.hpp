// Names and types of a System, for sources that need no more of it: they do not include system.hpp, so they are
// not compiled again when it changes.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "compiler/model/types.hpp"
#include "compiler/system/system_ids.hpp"

namespace bip::system {

[[nodiscard]] std::size_t atom_count(const System& system);
[[nodiscard]] std::size_t connector_count(const System& system);
/// "ROOT.phil[0]"; the row is below atom_count.
[[nodiscard]] const std::string& atom_path(const System& system, std::size_t row);
[[nodiscard]] const std::string& connector_path(const System& system, std::size_t row);
/// The type of the atom in this row of the atoms.
[[nodiscard]] const AtomType& type_of_atom(const System& system, std::size_t row);
/// All of them, by AtomTypeId.
[[nodiscard]] const std::vector<AtomType>& atom_types(const System& system);
/// Frees atoms and connectors: types and code stay. For a run whose image has all of the instances.
void release_instances(System& system);

}  // namespace bip::system
