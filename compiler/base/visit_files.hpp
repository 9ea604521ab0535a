// What lies below a folder.
//
// By fts (POSIX systems' own): the iterators of the standard library end the program where memory runs out between two
// entries, because their steps are noexcept (libstdc++, 12).
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <system_error>
#include <vector>

namespace bip {

/// What follows an entry.
enum class Visit : std::uint8_t { GoOn, SkipFolder, Stop };

struct FolderEntry {
  const std::filesystem::path& path;  // begins with the folder that was given
  int depth;                          // 0: in that folder
  bool is_folder;                     // a link to one is none
};

/// Calls `visit` with each entry below `folder`, a folder before what is in it, otherwise in no order. A folder that
/// may not be read is left out. Throws std::bad_alloc. Error: `folder` is none, or reading it or something below it
/// failed; then what could be read has been visited.
std::error_code visit_files(const std::filesystem::path& folder, const std::function<Visit(const FolderEntry&)>& visit);

/// The regular files below `folder`, and links to such, sorted. Error and std::bad_alloc: see visit_files.
std::vector<std::filesystem::path> files_below(const std::filesystem::path& folder, std::error_code& error);

}  // namespace bip
