// `bipc verify --for-all n`: the command's part around compiler/library/decide_sizes.hpp.
#pragma once
#include "compiler/driver/options.hpp"

namespace bip::driver {

/// Prints the verdict and returns the exit code. Requires `arguments.for_all`.
[[nodiscard]] int verify_for_all_sizes(const VerifyArguments& arguments);

}  // namespace bip::driver
