// From the runtime's image to the shapes of its interactions. See compiler/lower/steps.hpp and runtime/include/bip/steps.hpp.
#pragma once
#include "compiler/lower/lower.hpp"

namespace bip::steps {

/// Fills lowered.steps and the image's rows of them. Code must not have run yet; functions need not be there.
/// Linear in the image. What has no shape is left to the core; a system whose guards or priorities would need the core in
/// between has no steps at all.
void derive_steps(lower::LoweredSystem& lowered);

}  // namespace bip::steps
