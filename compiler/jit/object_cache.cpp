// See object_cache.hpp. A file is a line that names the format, the hash of the rest, the rest.
#include "compiler/jit/object_cache.hpp"

#include <llvm/ADT/StringExtras.h>
#include <llvm/Support/BLAKE3.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iterator>

namespace bip::jit {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kMagic = "bipc object 1\n";
constexpr std::size_t kHashSize = 64;
// What a process left that ended while it wrote.
constexpr std::chrono::hours kAbandoned{1};

bool is_kept_file(const fs::path& path) { return path.extension() == ".o" || path.extension() == ".so"; }

}  // namespace

std::string content_hash(const std::vector<std::string_view>& texts) {
  llvm::BLAKE3 hash;
  for (const std::string_view text : texts) {
    const std::uint64_t size = text.size();
    std::uint8_t bytes[8];
    for (unsigned k = 0; k < 8; ++k) bytes[k] = static_cast<std::uint8_t>(size >> (8 * k));
    hash.update(llvm::ArrayRef<std::uint8_t>(bytes, 8));
    hash.update(llvm::StringRef(text.data(), text.size()));
  }
  const auto digest = hash.final<32>();
  return llvm::toHex(llvm::ArrayRef<std::uint8_t>(digest.data(), digest.size()), true);
}

std::optional<std::string> ObjectCache::load(const std::string& name) {
  if (!is_on()) return std::nullopt;
  const fs::path path = folder_ / (name + ".o");
  std::ifstream in(path, std::ios::binary);
  if (!in) return std::nullopt;
  std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::string_view all = text;
  const std::size_t head = kMagic.size() + kHashSize;
  if (!all.starts_with(kMagic) || all.size() < head || content_hash({all.substr(head)}) != all.substr(kMagic.size(), kHashSize)) {
    broken_.push_back(path.string());
    return std::nullopt;
  }
  std::error_code ignored;
  fs::last_write_time(path, fs::file_time_type::clock::now(), ignored);
  text.erase(0, head);
  return text;
}

void ObjectCache::store(const std::string& name, std::string_view bytes) {
  if (!is_on()) return;
  std::error_code error;
  fs::create_directories(folder_, error);
  // A name that nobody else writes to.
  std::string fresh = (folder_ / (name + ".XXXXXX.new")).string();
  const int file = ::mkstemps(fresh.data(), 4);
  if (file < 0) return;
  ::close(file);
  {
    std::ofstream out(fresh, std::ios::binary);
    out << kMagic << content_hash({bytes});
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) {
      fs::remove(fresh, error);
      return;
    }
  }
  fs::rename(fresh, folder_ / (name + ".o"), error);
  if (error) fs::remove(fresh, error);
  else has_stored_ = true;
}

ObjectCache::~ObjectCache() {
  if (has_stored_) tidy();
}

// Others may do the same at the same time: a file that is gone is gone.
void ObjectCache::tidy() const {
  struct File {
    fs::file_time_type used;
    std::uint64_t bytes;
    fs::path path;
  };
  std::vector<File> files;
  std::uint64_t sum = 0;
  std::error_code error;
  const auto now = fs::file_time_type::clock::now();
  for (fs::directory_iterator entry(folder_, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code gone;
    const fs::file_time_type used = entry->last_write_time(gone);
    const std::uint64_t bytes = gone ? 0 : entry->file_size(gone);
    if (gone) continue;
    if (entry->path().extension() == ".new" && now - used > kAbandoned) fs::remove(entry->path(), gone);
    if (!is_kept_file(entry->path())) continue;
    files.push_back({used, bytes, entry->path()});
    sum += bytes;
  }
  if (sum <= most_bytes_) return;
  std::sort(files.begin(), files.end(), [](const File& a, const File& b) { return a.used != b.used ? a.used < b.used : a.path < b.path; });
  // Somewhat below the limit, so that not every run tidies.
  for (const File& file : files) {
    if (sum <= most_bytes_ / 4 * 3) break;
    if (fs::remove(file.path, error)) sum -= file.bytes;
  }
}

}  // namespace bip::jit
