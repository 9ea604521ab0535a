// The contract of an image: every row that a table names is there, and tables that belong together have as many rows.
//
// For assertions after `lower`: a broken rule ends the process with what it names (BIP_ASSERT), so that a fault of the
// compiler is not found as a wrong read of the runtime. Linear in the image, instances included.
#pragma once
#include "compiler/lower/lower.hpp"

namespace bip::lower {

/// Checks the image's tables against each other. Returns true: the rules are assertions of their own.
[[nodiscard]] bool check_image(const rt::Image& image);

/// Checks the image, and what lowering keeps beside it: units and their codes, sites, FFI rows. Returns true.
[[nodiscard]] bool check_lowered(const LoweredSystem& lowered);

}  // namespace bip::lower
