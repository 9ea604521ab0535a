// `bipc explore` for models with clocks: explores their zone graph (runtime/explore/zones.hpp).
#pragma once
#include "compiler/driver/options.hpp"
#include "compiler/pipeline/pipeline.hpp"

namespace bip::driver {

/// The image has its code. Returns the exit code.
[[nodiscard]] int explore_timed(const ExploreArguments& arguments, Compilation& c);

}  // namespace bip::driver
