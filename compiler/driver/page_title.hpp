// What a page is called.
#pragma once
#include <filesystem>
#include <string>

#include "compiler/system/system.hpp"

namespace bip::driver {

/// "Dinner (philosophers.bip)"
[[nodiscard]] inline std::string page_title(const System& system, const std::string& file) {
  return system.compounds.begin()->type + " (" + std::filesystem::path(file).filename().string() + ")";
}

}  // namespace bip::driver
