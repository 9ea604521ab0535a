// Judges a model as the solution of a lesson's exercises: `bipc check --lesson`.
#pragma once
#include <string>

#include "compiler/driver/options.hpp"

namespace bip::driver {

/// Prints for each exercise of `arguments.lesson` (`3`, or `3.2` for one exercise) whether the file solves it; if not,
/// the first check that fails, what was found, and its hint. Returns 0 if all are solved, 3 if not, 1 for a file with
/// errors, 2 if there is no such lesson.
[[nodiscard]] int judge_lesson(const CheckArguments& arguments);

}  // namespace bip::driver
