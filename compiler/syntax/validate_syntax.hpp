// The promises that syntax.hpp makes about a tree, checked: for --verify-each and checked builds.
#pragma once
#include <string>
#include <vector>

#include "compiler/syntax/syntax.hpp"

namespace bip::syntax {

/// Returns each broken promise of the tree of a file that was read without errors, at most kMaxBroken; empty if sound.
/// Ranges lie in the file and in the range around them, names are the text at their range, nothing is null that may
/// not be. Linear in the tree; recursive, as deep as the parser lets expressions and statements be.
[[nodiscard]] std::vector<std::string> validate(const Syntax& syntax, const SourceMap& sources);

inline constexpr std::size_t kMaxBroken = 100;

}  // namespace bip::syntax
