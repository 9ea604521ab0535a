// See cache_folder.hpp.
#include "compiler/driver/cache_folder.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>

namespace bip::driver {

namespace fs = std::filesystem;

fs::path cache_folder(const CacheOptions& options) {
  if (options.is_off) return {};
  if (!options.folder.empty()) return options.folder;
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  std::error_code error;
  if (cache != nullptr && *cache != '\0') return fs::path(cache) / "bipc";
  if (home != nullptr && *home != '\0') return fs::path(home) / ".cache" / "bipc";
  return fs::temp_directory_path(error) / fmt::format("bipc-cache-{}", ::getuid());
}

}  // namespace bip::driver
