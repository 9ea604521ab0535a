// Reduces a failing model: one edit at a time, kept if the failure persists.
#pragma once
#include <functional>

#include "tools/gen/description.hpp"

namespace bip::gen {

/// Applies the n-th possible edit. False if there are fewer.
bool apply_edit(Description& model, std::size_t n);
/// Drops what refers to something that is not there, and what is not used, until nothing changes.
void tidy(Description& model);

/// Tries edits, coarse ones first, until none keeps the failure or `budget` attempts are used.
[[nodiscard]] Description shrink(Description model, const std::function<bool(const Description&)>& still_fails,
                                 int budget);

}  // namespace bip::gen
