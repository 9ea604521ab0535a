// See content_cache.hpp. A file consists of a line that names the format, the hash of the name and the rest, and the
// rest.
#include "compiler/base/content_cache.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <new>

#include "compiler/base/content_hash.hpp"
#include "compiler/base/read_file.hpp"
#include "compiler/base/visit_files.hpp"
#include "compiler/base/write_file.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kHashSize = 64;
// What a process left that ended while it wrote.
constexpr std::chrono::hours kAbandoned{1};

std::string_view magic_of(ContentKind kind) {
  switch (kind) {
    case ContentKind::Object: return "bipc object 3\n";
    case ContentKind::Library: return "bipc library 1\n";
    case ContentKind::Proof: return "bipc proof 2\n";
  }
  BIP_UNREACHABLE("a kind of kept files");
}
const char* extension_of(ContentKind kind) {
  switch (kind) {
    case ContentKind::Object: return ".o";
    case ContentKind::Library: return ".so";
    case ContentKind::Proof: return ".proof";
  }
  BIP_UNREACHABLE("a kind of kept files");
}
bool is_kept_file(const fs::path& path) {
  return path.extension() == ".o" || path.extension() == ".so" || path.extension() == ".proof";
}
// The name counts: a sound file under another name says something about another thing.
std::string hash_of(const std::string& name, std::string_view bytes) { return content_hash({name, bytes}); }

// bipc executes machine code from the folder, so only the user may be able to write to it.
bool is_private(const fs::path& folder) {
  struct stat status {};
  return ::stat(folder.c_str(), &status) == 0 && S_ISDIR(status.st_mode) && status.st_uid == ::geteuid() &&
         (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

// With the folders above it that are missing. False: it cannot be made.
bool make_private_folder(const fs::path& folder) {
  if (::mkdir(folder.c_str(), 0700) == 0 || errno == EEXIST) return true;
  if (errno != ENOENT || !folder.has_relative_path() || folder.parent_path() == folder) return false;
  return make_private_folder(folder.parent_path()) && (::mkdir(folder.c_str(), 0700) == 0 || errno == EEXIST);
}

}  // namespace

std::optional<std::string> ContentCache::load(const std::string& name) {
  if (!is_on() || !is_private(folder_)) return std::nullopt;
  const fs::path path = folder_ / (name + extension_of(kind_));
  std::error_code error;
  // A pipe would wait for a writer, and what is larger than all that may be kept is none of ours.
  if (!fs::is_regular_file(path, error)) return std::nullopt;
  if (fs::file_size(path, error) > most_bytes_ || error) {
    if (!error) broken_.push_back(path.string());
    return std::nullopt;
  }
  std::optional<std::string> text = read_file(path);
  if (!text) return std::nullopt;
  const std::string_view all = *text;
  const std::string_view magic = magic_of(kind_);
  const std::size_t head = magic.size() + kHashSize;
  if (!all.starts_with(magic) || all.size() < head ||
      hash_of(name, all.substr(head)) != all.substr(magic.size(), kHashSize)) {
    broken_.push_back(path.string());
    return std::nullopt;
  }
  fs::last_write_time(path, fs::file_time_type::clock::now(), error);
  text->erase(0, head);
  return text;
}

bool ContentCache::store(const std::string& name, std::string_view bytes) {
  if (!is_on()) return false;
  if (!make_private_folder(folder_) || !is_private(folder_)) return false;
  std::string contents(magic_of(kind_));
  contents += hash_of(name, bytes);
  contents += bytes;
  // After a power failure the hash tells a file that is not complete.
  if (!write_file(folder_ / (name + extension_of(kind_)), contents, Durability::Unsynced)) return false;
  has_stored_ = true;
  return true;
}

ContentCache::~ContentCache() {
  try {
    if (has_stored_) tidy();
  } catch (const std::bad_alloc&) {
    // The next one tidies.
  }
}

// Others may do the same at the same time: a file that is gone is gone.
void ContentCache::tidy() const {
  struct File {
    fs::file_time_type used;
    std::uint64_t bytes;
    fs::path path;
  };
  std::vector<File> files;
  std::uint64_t sum = 0;
  const auto now = fs::file_time_type::clock::now();
  visit_files(folder_, [&](const FolderEntry& entry) {
    std::error_code gone;
    const fs::file_time_type used = fs::last_write_time(entry.path, gone);
    const std::uint64_t bytes = gone || entry.is_folder ? 0 : fs::file_size(entry.path, gone);
    if (gone || entry.is_folder) return Visit::SkipFolder;
    if (entry.path.extension() == ".new" && now - used > kAbandoned) fs::remove(entry.path, gone);
    if (!is_kept_file(entry.path)) return Visit::GoOn;
    files.push_back({used, bytes, entry.path});
    sum += bytes;
    return Visit::GoOn;
  });
  if (sum <= most_bytes_) return;
  std::sort(files.begin(), files.end(),
            [](const File& a, const File& b) { return a.used != b.used ? a.used < b.used : a.path < b.path; });
  // Somewhat below the limit, so that not every run tidies.
  for (const File& file : files) {
    if (sum <= most_bytes_ / 4 * 3) break;
    std::error_code gone;
    if (fs::remove(file.path, gone)) sum -= file.bytes;
  }
}

}  // namespace bip
