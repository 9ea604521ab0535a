// Which of genom3's mappings the codels of a component use, C or C++: seen from the header that their files include.
#pragma once
#include <string>
#include <vector>

#include "compiler/genom/module.hpp"

namespace bip::genom {

/// Sets `is_cxx` of components whose codels include `acNAME.hpp` or `NAME_cxx_types.hpp`. Reports components whose
/// `lang` is neither C nor C++, and those whose codels use both mappings. A file that cannot be read counts as empty:
/// the compiler will report it.
void find_mappings(std::vector<Module>& modules, const std::vector<std::string>& codel_files, Diagnostics& diags);

}  // namespace bip::genom
