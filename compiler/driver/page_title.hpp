// What a page is called.
#pragma once
#include <string>

#include "compiler/system/system_ids.hpp"

namespace bip::driver {

/// "Dinner (philosophers.bip)"
[[nodiscard]] std::string page_title(const System& system, const std::string& file);

}  // namespace bip::driver
