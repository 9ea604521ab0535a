// `bipc explore` and `bipc verify` for models with clocks: explores their zone graph (runtime/explore/zones.hpp).
#pragma once
#include "compiler/driver/options.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "compiler/verify/portfolio/portfolio.hpp"

namespace bip::driver {

/// The image has its code. Returns the exit code.
[[nodiscard]] int explore_timed(const ExploreArguments& arguments, Compilation& c);

/// Decides by the zone graph whether a model with time has a deadlock or time lock, a run-time error, or violates a
/// property of places and data, and prints the verdict, with the note. Returns the exit code.
[[nodiscard]] int verify_timed(const VerifyArguments& arguments, Compilation& c, const verify::Question& question,
                               const std::string& note);

}  // namespace bip::driver
