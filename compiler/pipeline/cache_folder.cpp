// See cache_folder.hpp.
#include "compiler/pipeline/cache_folder.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

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

namespace {

// Why nothing can be kept in the folder; empty if something can. What is missing of it is made when it is needed.
std::string problem_of(const fs::path& folder) {
  fs::path at = folder;
  struct stat status {};
  while (::stat(at.c_str(), &status) != 0) {
    if (errno != ENOENT || at.parent_path() == at) return std::strerror(errno);
    at = at.has_relative_path() ? at.parent_path() : at;
    if (at.empty()) at = ".";
  }
  if (!S_ISDIR(status.st_mode)) return fmt::format("`{}` is no folder", at.string());
  if (at == folder && status.st_uid != ::geteuid()) return "it belongs to another user";
  if (at == folder && (status.st_mode & (S_IWGRP | S_IWOTH)) != 0) return "others may write to it";
  return ::access(at.c_str(), W_OK | X_OK) == 0 ? std::string() : std::strerror(errno);
}

}  // namespace

void warn_of_unusable_cache(Compilation& c, const CacheOptions& options) {
  const fs::path folder = cache_folder(options);
  if (folder.empty()) return;
  const std::string problem = problem_of(folder);
  if (problem.empty()) return;
  for (const Diagnostic* d : c.diags.sorted())
    if (d->kind == Diag::kB5015) return;
  c.diags.report(Diag::kB5015, {}, folder.string(), problem)
      .help("`--cache DIR` names another folder, `--no-cache` does without");
}

std::string cache_version() {
  return std::string(BIPC_VERSION) + "+" + build_id_of(reinterpret_cast<const void*>(&cache_version));
}

}  // namespace bip::pipeline
