// What the cache keeps of a model's C++: the library, with a hash of everything that the compiler read for it.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace bip::pipeline {

/// Returns the prerequisites of a make rule as compilers write it (-MD): without the target, escapes undone.
[[nodiscard]] std::vector<std::string> prerequisites(std::string_view rule);

/// Returns the entry of a library that was made of texts with this hash (content_hash.hpp).
[[nodiscard]] std::string pack_library(std::string_view hash, std::string_view library);

/// Returns the library of an entry; nothing if it was made of other texts.
[[nodiscard]] std::optional<std::string_view> unpack_library(std::string_view hash, std::string_view entry);

}  // namespace bip::pipeline
