// What the cache keeps of a model's C++: the library, with the hashes of all files that the compiler read for it.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace bip::pipeline {

/// Returns the prerequisites of a make rule as compilers write it (-MD): without the target, escapes undone.
[[nodiscard]] std::vector<std::string> prerequisites(std::string_view rule);

/// Returns the entry of a library that was made of `files`; nothing if a file cannot be read.
[[nodiscard]] std::optional<std::string> pack_library(std::vector<std::string> files, std::string_view library);

/// Returns the library of an entry; nothing if one of its files is not what it was. Cost: reading and hashing the
/// files.
[[nodiscard]] std::optional<std::string_view> unpack_library(std::string_view entry);

}  // namespace bip::pipeline
