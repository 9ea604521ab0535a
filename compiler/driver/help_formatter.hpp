// How `--help` prints options: those that a beginner never needs only with `--help-all`.
#pragma once
#include "compiler/driver/cli_options.hpp"

namespace bip::driver {

/// Moves the options that few people need into a group of their own, in each command of `app`, which must have all of
/// them, and makes `--help` leave this group out and say so.
void hide_rare_options(CLI::App& app);

}  // namespace bip::driver
