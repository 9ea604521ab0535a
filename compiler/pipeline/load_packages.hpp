// Loads the packages that a file uses: package a.b.C is a/b/C.bip below one of the folders that are searched.
//
// Requires the compiled file to be parsed. Fills c.packages: a package after those it uses, the compiled one last.
// Folders are those of -I in their order, then the compiled file's own (the folder above a/b if it is a/b/C.bip with
// package a.b.C), then the standard library. Each file is read once.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "compiler/pipeline/pipeline.hpp"

namespace bip::pipeline {

/// False if a package is missing, broken, misnamed or part of a circle (reported).
[[nodiscard]] bool load_packages(Compilation& c);

/// Packages below the folders, sorted; the first 2,000 entries of the folders are looked at, to a depth of 4.
[[nodiscard]] std::vector<std::string> packages_below(const std::vector<std::filesystem::path>& folders);

/// The folder in which the packages are that a file of this path and package uses, but for those of -I and the library:
/// the folder above a/b if the path ends in a/b/C.bip and the package is a.b.C.
[[nodiscard]] std::string folder_of_packages(const std::filesystem::path& path, const std::string& package);

/// Where the standard library is: `std/ports.bip` and others are below it. Empty if it is not installed.
[[nodiscard]] std::string find_stdlib();

/// "a.b.C" -> "a/b/C.bip".
[[nodiscard]] std::string file_of_package(const std::string& package);

}  // namespace bip::pipeline
