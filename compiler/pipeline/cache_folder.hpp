// The folder of the cache: machine code of the JIT, compiled C++ of models, and proofs.
#pragma once
#include <filesystem>
#include <string>

#include "compiler/pipeline/options.hpp"
#include "compiler/pipeline/pipeline.hpp"

namespace bip::pipeline {

/// The folder that was asked for, else $XDG_CACHE_HOME/bipc or ~/.cache/bipc; relative values of these variables are
/// ignored. It need not exist. Empty if nothing is to be kept: also without a home.
[[nodiscard]] std::filesystem::path cache_folder(const CacheOptions& options);

/// Warns, once in a compilation, if the folder cannot be made or written, or others may write to it: then nothing is
/// kept. Cost: some system calls.
void warn_of_unusable_cache(Compilation& c, const CacheOptions& options);

/// The version and the build of this program: part of the name of everything that the cache keeps.
[[nodiscard]] std::string cache_version();

}  // namespace bip::pipeline
