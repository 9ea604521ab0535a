// Derives the shapes of interactions from the runtime's image. See compiler/lower/step_shapes.hpp for the operations
// and runtime/include/bip/steps.hpp for how they are executed.
#pragma once
#include "compiler/lower/lower.hpp"

namespace bip::steps {

/// Fills lowered.steps and the image's rows of them. Code must not have run yet; functions need not be there.
/// Linear in the image. What has no shape is left to the core; a system whose guards or priorities would need the core
/// in between has no steps at all. Columns: where the loop over steps has its data in columns. Wherever that is
/// possible, also if the core takes every second step and data go to and fro, is for tests.
enum class Columns : std::uint8_t { WhereOfUse, WherePossible };
void derive_steps(lower::LoweredSystem& lowered, Columns columns = Columns::WhereOfUse);

}  // namespace bip::steps
