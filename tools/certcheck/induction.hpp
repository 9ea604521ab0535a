// The part of a certificate that is proved by induction over the steps.
#pragma once
#include <z3++.h>

#include "tools/certcheck/certificate.hpp"

namespace certcheck {

/// What a set says, of variables for (atom, state); those without one are never reached.
[[nodiscard]] z3::expr satisfied(const Set& set, z3::context& z, const std::vector<std::map<std::size_t, z3::expr>>& modes);
/// Classes and sets must have been checked. Throws Rejected or NotCheckable.
void check_induction(const Model& model, const Certificate& certificate);

}  // namespace certcheck
