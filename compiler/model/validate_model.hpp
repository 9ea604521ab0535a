// The promises that model.hpp and types.hpp make about a type model, checked: for --verify-each and checked builds.
#pragma once
#include <string>
#include <vector>

#include "compiler/model/model.hpp"

namespace bip::model {

/// Returns each broken promise of a model that was built without errors, at most kMaxBrokenPromises; empty if sound.
/// Ids name rows, `define` trees are trees in preorder, ranges of bound variables follow each other, lists that are
/// promised sorted are. Types of code are checked in the System, where all of it has an owner. Linear in the model.
[[nodiscard]] std::vector<std::string> validate(const Model& model);

inline constexpr std::size_t kMaxBrokenPromises = 100;

}  // namespace bip::model
