// See page_title.hpp.
#include "compiler/driver/page_title.hpp"

#include <filesystem>

#include "compiler/system/system.hpp"

namespace bip::driver {

std::string page_title(const System& system, const std::string& file) {
  return system.compounds.begin()->type + " (" + std::filesystem::path(file).filename().string() + ")";
}

}  // namespace bip::driver
