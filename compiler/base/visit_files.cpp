// See visit_files.hpp.
#include "compiler/base/visit_files.hpp"

#include <fts.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <string>
#include <utility>

#include "compiler/base/out_of_memory.hpp"

namespace bip {

namespace {

namespace fs = std::filesystem;

std::error_code error_of(int number) {
  if (number == ENOMEM) throw_out_of_memory();
  return {number, std::generic_category()};
}

// A folder that may not be read, what is gone by now, and links that lead nowhere.
bool is_left_out(int number) {
  return number == EACCES || number == EPERM || number == ENOENT || number == ENOTDIR || number == ELOOP;
}

}  // namespace

std::error_code visit_files(const fs::path& folder, const std::function<Visit(const FolderEntry&)>& visit) {
  std::string root = folder.string();
  char* const roots[] = {root.data(), nullptr};
  const std::unique_ptr<FTS, int (*)(FTS*)> tree(fts_open(roots, FTS_PHYSICAL | FTS_COMFOLLOW | FTS_NOCHDIR, nullptr),
                                                 fts_close);
  if (tree == nullptr) return error_of(errno);
  std::error_code first;  // of entries
  while (true) {
    errno = 0;
    FTSENT* const entry = fts_read(tree.get());
    if (entry == nullptr) return errno == 0 ? first : error_of(errno);
    const bool is_root = entry->fts_level == FTS_ROOTLEVEL;
    switch (entry->fts_info) {
      case FTS_DP: continue;
      case FTS_DNR:
      case FTS_ERR:
      case FTS_NS:
        if (is_root || entry->fts_errno == ENOMEM) return error_of(entry->fts_errno);
        if (!is_left_out(entry->fts_errno) && !first) first = error_of(entry->fts_errno);
        continue;
      default: break;
    }
    const bool is_folder = entry->fts_info == FTS_D || entry->fts_info == FTS_DC;
    if (is_root) {
      if (!is_folder) return {ENOTDIR, std::generic_category()};
      continue;
    }
    const fs::path path(entry->fts_path);
    switch (visit({path, entry->fts_level - 1, is_folder})) {
      case Visit::GoOn: break;
      case Visit::SkipFolder: fts_set(tree.get(), entry, FTS_SKIP); break;
      case Visit::Stop: return {};
    }
  }
}

std::vector<fs::path> files_below(const fs::path& folder, std::error_code& error) {
  std::vector<fs::path> files;
  std::error_code first;  // of entries
  error = visit_files(folder, [&](const FolderEntry& entry) {
    if (entry.is_folder) return Visit::GoOn;
    std::error_code unknown;
    const bool is_file = fs::is_regular_file(entry.path, unknown);
    if (is_file) files.push_back(entry.path);
    if (unknown.value() == ENOMEM) throw_out_of_memory();
    if (unknown && !is_left_out(unknown.value()) && !first) first = unknown;
    return Visit::GoOn;
  });
  if (!error) error = first;
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace bip
