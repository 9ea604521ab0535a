// The part of a certificate that is proved by induction over the steps.
#pragma once
#include "tools/certcheck/certificate.hpp"

namespace certcheck {

/// Classes and sets must have been checked. Throws Rejected or NotCheckable.
void check_induction(const Model& model, const Certificate& certificate);

}  // namespace certcheck
