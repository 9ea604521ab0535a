// What codels and services of a GenoM 3 component say of data: members, ports and parameters that are there, ports in
// their direction, initial values whose names their types have. Linear in the description, with a lookup a name.
#pragma once
#include "compiler/diag/diagnostics.hpp"
#include "compiler/genom/idl.hpp"

namespace bip::genom {

/// False: something was reported (B6008, B6021, B6028).
[[nodiscard]] bool check_data(const idl::Component& component, Diagnostics& diags);

}  // namespace bip::genom
