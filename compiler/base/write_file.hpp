// Writes files so that readers see the old contents or the new ones, and never a part.
//
// The new contents are written to a new file beside the target (opened with O_EXCL, so no file or link of another user
// is followed), brought to the disk (fsync) and renamed over the target. A target that is no regular file (a pipe, a
// device) is written directly. After a failure the old file is as it was and the new one is removed; so it is when
// SIGINT, SIGTERM or SIGHUP comes meanwhile, before the signal ends the process.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "compiler/base/delay_signals.hpp"
#include "compiler/base/result.hpp"

namespace bip {

/// Synced: a file that is there after the call survives a power failure. Unsynced: for what can be made again.
enum class Durability : std::uint8_t { Synced, Unsynced };

/// Who may read a new file: who the umask lets, or its owner alone (keys).
enum class Readers : std::uint8_t { ByUmask, OwnerAlone };

/// A new file beside its target, which takes the target's place with commit(); otherwise it is removed. For a target
/// that is there and no regular file (a pipe, a device) it is among the temporary files, and commit() copies it.
class NewFile {
 public:
  [[nodiscard]] static Result<NewFile> create(const std::filesystem::path& target, Readers readers = Readers::ByUmask);
  NewFile(NewFile&& other) noexcept;
  NewFile& operator=(NewFile&&) = delete;
  ~NewFile();

  /// The path to write to, for a program that writes the file.
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] Result<bool> write(std::string_view text);
  /// Renames the file over its target, or copies it into a target that is no regular file.
  [[nodiscard]] Result<bool> commit(Durability durability);

 private:
  NewFile(std::unique_ptr<DelayedSignals> signals, std::filesystem::path target, std::filesystem::path path, int file,
          bool is_copied);
  void close();

  std::unique_ptr<DelayedSignals> signals_;  // last to go: the file has been removed by then
  std::filesystem::path target_, path_;      // path_: empty after commit
  int file_;                                 // negative: closed
  bool is_copied_;                           // the target is no regular file
};

/// Whether a file can be written there, without writing one; else the reason.
[[nodiscard]] Result<bool> can_be_written(const std::filesystem::path& target);

/// Replaces the contents of `path`. An existing file keeps its permissions; a link is followed. `-` is standard output,
/// whose losses the end of the process reports (bip/process.hpp).
[[nodiscard]] Result<bool> write_file(const std::filesystem::path& path, std::string_view text,
                                      Durability durability = Durability::Synced);

/// Returns whether both paths name the same existing file, by whatever links.
[[nodiscard]] bool is_same_file(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace bip
