// Where the parts of an installation are: the JIT's plug-in, the standard library, the runtime's sources.
//
// They are looked for from the file that this code is in: the program bipc, or a library that another program loaded.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace bip::pipeline {

/// The running program's file, through links; empty if the system does not say.
[[nodiscard]] std::filesystem::path program_file();

/// The file of the program or library that holds this function, through links; empty if the system does not say.
[[nodiscard]] std::filesystem::path own_file();

/// Where a part of this name may be, in the order in which it is looked for: beside us (a build tree, a Python
/// package), in lib/bipc, in share/bipc. The paths need not exist.
[[nodiscard]] std::vector<std::filesystem::path> places_of_part(const std::string& name);

}  // namespace bip::pipeline
