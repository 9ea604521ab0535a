// The folder of the cache: machine code of the JIT, compiled C++ of models, and proofs.
#pragma once
#include <filesystem>

#include "compiler/driver/options.hpp"

namespace bip::driver {

/// The folder that was asked for, else $XDG_CACHE_HOME/bipc, ~/.cache/bipc, or one of the user's in the folder for
/// temporary files. It need not exist. Empty if nothing is to be kept.
[[nodiscard]] std::filesystem::path cache_folder(const CacheOptions& options);

}  // namespace bip::driver
