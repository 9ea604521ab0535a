// The source map: texts of files, byte ranges, and their lines and columns.
//
// Texts are neither moved nor freed while the map exists, so names in the syntax tree are views into them.
#pragma once
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/include/bip/ids.hpp"
#include "compiler/base/result.hpp"

namespace bip {

using FileId = Id<struct FileTag>;

/// Bytes [begin, end) of a file.
struct SourceRange {
  FileId file;
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
  [[nodiscard]] bool is_valid() const { return file.is_valid(); }
};

/// A place as people write it; line and column start at 1, columns count bytes. file is a row of the System's or the
/// map's file table. line 0 = no place.
struct Loc {
  std::uint32_t file = 0;
  std::uint32_t line = 0;
  std::uint32_t column = 0;
  friend bool operator==(const Loc&, const Loc&) = default;
};

class SourceMap {
 public:
  /// Limit for one file (bytes); larger ones are refused by `load`.
  static constexpr std::size_t kMaxFileBytes = 64u << 20;

  /// Adds a text under a display name.
  FileId add(std::string name, std::string text);
  /// Reads a file. Fails with a one-line reason if it is not there, not a file, too large or not UTF-8 (with the line).
  /// `name`: what it is called in messages; empty: its path.
  Result<FileId> load(const std::string& path, std::string name = {});
  /// The same for a text that is in memory already.
  Result<FileId> load_text(std::string name, std::string text);

  [[nodiscard]] std::string_view text(FileId id) const;
  /// What of the range lies in the text.
  [[nodiscard]] std::string_view text(SourceRange r) const;
  [[nodiscard]] const std::string& name(FileId id) const;
  [[nodiscard]] std::size_t size() const { return files_.size(); }
  /// Line and column of a byte offset: O(log lines).
  [[nodiscard]] Loc loc(FileId id, std::uint32_t offset) const;
  [[nodiscard]] Loc loc(SourceRange r) const { return r.is_valid() ? loc(r.file, r.begin) : Loc{}; }
  /// The text of a 1-based line without its line break.
  [[nodiscard]] std::string_view line(FileId id, std::uint32_t line) const;

 private:
  struct File {
    std::string name;
    std::string text;
    std::vector<std::uint32_t> line_starts;
  };
  std::deque<File> files_;
};

}  // namespace bip
