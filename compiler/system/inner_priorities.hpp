// Does a priority order connectors that export a port? Their interactions are hidden below the connectors that bind
// them, so a system may stop although interactions are offered: analyses that take priorities for a choice among steps
// ask first.
#pragma once
#include <string>

#include "compiler/system/system_ids.hpp"

namespace bip::system {

/// "priority `pr` orders connectors that export a port": the first one. Empty: there is none. The runtime decides the
/// same on the image (runtime/core/link/link_inner_rules.cpp).
[[nodiscard]] std::string first_inner_priority(const System& system);

}  // namespace bip::system
