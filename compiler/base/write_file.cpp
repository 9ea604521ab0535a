// See write_file.hpp.
#include "compiler/base/write_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <optional>
#include <utility>

#include "compiler/base/read_file.hpp"

namespace bip {

namespace fs = std::filesystem;

namespace {

constexpr int kMaxLinks = 40;
// Names that are tried before the folder counts as unusable.
constexpr int kMaxNames = 100;
// File systems have names of at most 255 bytes; ours adds less than 55 to the target's.
constexpr std::size_t kMaxStem = 200;

Failure failure_of(int error) { return Failure{std::strerror(error)}; }

// The file at the end of links; it need not exist.
fs::path follow_links(fs::path path) {
  std::error_code error;
  for (int k = 0; k < kMaxLinks && fs::is_symlink(path, error); ++k) {
    const fs::path next = fs::read_symlink(path, error);
    if (error) break;
    path = path.parent_path() / next;
  }
  return path;
}

// Writes everything, or returns the error's number.
int write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t done = ::write(file, text.data(), text.size());
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) return errno;
    text.remove_prefix(static_cast<std::size_t>(done));
  }
  return 0;
}

// A file system that cannot sync the file says EINVAL.
int sync_file(int file) { return ::fsync(file) != 0 && errno != EINVAL && errno != EROFS ? errno : 0; }

Result<bool> write_directly(const fs::path& path, std::string_view text) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY);
  if (file < 0) return failure_of(errno);
  int error = write_all(file, text);
  if (::close(file) != 0 && error == 0) error = errno;
  if (error != 0) return failure_of(error);
  return true;
}

}  // namespace

NewFile::NewFile(std::unique_ptr<DelayedSignals> signals, fs::path target, fs::path path, int file, bool is_copied)
    : signals_(std::move(signals)),
      target_(std::move(target)),
      path_(std::move(path)),
      file_(file),
      is_copied_(is_copied) {}

NewFile::NewFile(NewFile&& other) noexcept
    : signals_(std::move(other.signals_)),
      target_(std::move(other.target_)),
      path_(std::move(other.path_)),
      file_(std::exchange(other.file_, -1)),
      is_copied_(other.is_copied_) {
  other.path_.clear();
}

NewFile::~NewFile() {
  close();
  if (!path_.empty()) ::unlink(path_.c_str());
}

void NewFile::close() {
  if (file_ >= 0) ::close(std::exchange(file_, -1));
}

namespace {

struct Target {
  fs::path path;  // without links
  bool is_kept;   // a pipe or a device, which is written into; a regular file is replaced
};

Result<Target> examine(const fs::path& target) {
  fs::path path = follow_links(target);
  struct stat old {};
  const bool exists = ::stat(path.c_str(), &old) == 0;
  if (exists && S_ISDIR(old.st_mode)) return failure_of(EISDIR);
  return Target{std::move(path), exists && !S_ISREG(old.st_mode)};
}

}  // namespace

Result<bool> can_be_written(const fs::path& target) {
  const Result<Target> examined = examine(target);
  if (!examined) return Failure{examined.error()};
  const auto& [final, is_kept] = *examined;
  const fs::path folder = final.parent_path().empty() ? fs::path(".") : final.parent_path();
  struct stat parent {};
  if (::stat(folder.c_str(), &parent) != 0) return failure_of(errno);
  if (!S_ISDIR(parent.st_mode)) return failure_of(ENOTDIR);
  if (::access(is_kept ? final.c_str() : folder.c_str(), is_kept ? W_OK : W_OK | X_OK) != 0) return failure_of(errno);
  return true;
}

Result<NewFile> NewFile::create(const fs::path& target, Readers readers) {
  static std::atomic<unsigned> next{0};
  const Result<Target> examined = examine(target);
  if (!examined) return Failure{examined.error()};
  const auto& [final, is_copied] = *examined;
  std::error_code unusable;
  const fs::path folder = is_copied ? fs::temp_directory_path(unusable) : final.parent_path();
  if (unusable) return Failure{unusable.message()};
  const std::string stem = final.filename().string().substr(0, kMaxStem);
  const mode_t mode = readers == Readers::OwnerAlone ? S_IRUSR | S_IWUSR : 0666;
  auto signals = std::make_unique<DelayedSignals>();
  for (int k = 0; k < kMaxNames; ++k) {
    const std::string name = "." + stem + "." + std::to_string(::getpid()) + "-" + std::to_string(next++) + ".new";
    // Copied before there is a file, which nothing would remove if memory ended here.
    fs::path path = folder / name, end = final;
    const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    if (file >= 0) return NewFile(std::move(signals), std::move(end), std::move(path), file, is_copied);
    if (errno != EEXIST) return failure_of(errno);
  }
  return failure_of(EEXIST);
}

Result<bool> NewFile::write(std::string_view text) {
  if (const int error = write_all(file_, text); error != 0) return failure_of(error);
  return true;
}

Result<bool> NewFile::commit(Durability durability) {
  // A program that wrote the file may have replaced it by another of the same name.
  close();
  if (is_copied_) {
    const std::optional<std::string> text = read_file(path_.string());
    if (!text) return failure_of(errno);
    // Before the writing, which SIGPIPE may end together with the process.
    ::unlink(path_.c_str());
    path_.clear();
    // Nothing is left to remove, and the reader of a pipe may never come.
    signals_.reset();
    return write_directly(target_, *text);
  }
  if (durability == Durability::Synced) {
    const int file = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) return failure_of(errno);
    const int error = sync_file(file);
    ::close(file);
    if (error != 0) return failure_of(error);
  }
  if (::rename(path_.c_str(), target_.c_str()) != 0) return failure_of(errno);
  path_.clear();
  if (durability == Durability::Unsynced) return true;
  // The new name, too. The contents are safe by now, so a folder that cannot be synced is no failure.
  const fs::path folder = target_.parent_path().empty() ? fs::path(".") : target_.parent_path();
  if (const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); file >= 0) {
    (void)sync_file(file);
    ::close(file);
  }
  return true;
}

Result<bool> write_file(const fs::path& path, std::string_view text, Durability durability) {
  if (path == "-") {
    // A loss is found by finish_standard_output(), like that of everything else that is printed.
    std::fwrite(text.data(), 1, text.size(), stdout);
    return true;
  }
  struct stat old {};
  const bool exists = ::stat(path.c_str(), &old) == 0;
  if (exists && S_ISDIR(old.st_mode)) return failure_of(EISDIR);
  if (exists && !S_ISREG(old.st_mode)) return write_directly(path, text);
  Result<NewFile> file = NewFile::create(path);
  if (!file) return Failure{file.error()};
  if (Result<bool> written = file->write(text); !written) return written;
  if (exists) (void)::chmod(file->path().c_str(), old.st_mode & 07777);
  return file->commit(durability);
}

bool is_same_file(const fs::path& a, const fs::path& b) {
  struct stat first {
  }, second{};
  return ::stat(a.c_str(), &first) == 0 && ::stat(b.c_str(), &second) == 0 && first.st_dev == second.st_dev &&
         first.st_ino == second.st_ino;
}

}  // namespace bip
