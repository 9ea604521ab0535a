// Is this certificate a proof?
#pragma once
#include "tools/certcheck/certificate.hpp"

namespace certcheck {

/// Says how much was checked; throws Rejected or NotCheckable.
[[nodiscard]] std::string check(const Model& model, const std::string& certificate);

/// Modes are closed, reachable ones and sets are kept by every step (structure.cpp).
void check_structure(const Model& model, const Certificate& certificate);

}  // namespace certcheck
