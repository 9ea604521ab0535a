// The C++ of `bipc genom --processes`: tables of what each module's process runs, and the functions through which BIP
// calls it (runtime/include/bip/codel_processes.hpp). Internal to compiler/genom.
#pragma once
#include <string>
#include <vector>

#include "compiler/genom/generate_package.hpp"
#include "compiler/genom/module.hpp"

namespace bip::genom {

/// Of the header: what codels written as `int f(int& report)` need; for codels of genom3, declarations.
[[nodiscard]] std::string process_declarations(const std::vector<Module>& modules, const GenerateOptions& options);
/// Of the source between BIP and codels of genom3. `posters`, `readers`: rows of bip::processes::PosterRow, ReaderRow.
[[nodiscard]] std::string process_definitions(const std::vector<Module>& modules, const GenerateOptions& options,
                                              const std::string& posters, const std::string& readers);

}  // namespace bip::genom
