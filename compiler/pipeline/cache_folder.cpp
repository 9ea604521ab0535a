// See cache_folder.hpp.
#include "compiler/pipeline/cache_folder.hpp"

#include <cstdlib>

#include "compiler/base/build_id.hpp"

namespace bip::pipeline {

namespace fs = std::filesystem;

fs::path cache_folder(const CacheOptions& options) {
  if (options.is_off) return {};
  if (!options.folder.empty()) return options.folder;
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  // A relative path would name another folder in each working directory, which may belong to another user.
  if (cache != nullptr && fs::path(cache).is_absolute()) return fs::path(cache) / "bipc";
  if (home != nullptr && fs::path(home).is_absolute()) return fs::path(home) / ".cache" / "bipc";
  return {};
}

std::string cache_version() {
  return std::string(BIPC_VERSION) + "+" + build_id_of(reinterpret_cast<const void*>(&cache_version));
}

}  // namespace bip::pipeline
