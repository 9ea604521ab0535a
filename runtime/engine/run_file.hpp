// A file that a run writes: its trace, or the record of its events. Failures are kept and reported when it is closed.
#pragma once
#include <cstdio>
#include <string>
#include <string_view>
#include <utility>

namespace bip::rt {

/// An empty path is no file: nothing is opened, and closing it succeeds.
class RunFile {
 public:
  RunFile(std::string path, std::FILE* err) : path_(std::move(path)), err_(err) {}
  RunFile(const RunFile&) = delete;
  RunFile& operator=(const RunFile&) = delete;
  ~RunFile() { (void)close(); }
  /// Returns false after a report to `err`.
  [[nodiscard]] bool open();
  [[nodiscard]] bool is_open() const { return file_ != nullptr; }
  /// Hands the text to the system at once. Requires is_open().
  void write(std::string_view text);
  /// Closes the file, once. Returns false after a report to `err` if not all of it could be written.
  bool close();

 private:
  std::string path_;
  std::FILE* err_;
  std::FILE* file_ = nullptr;
  int error_ = 0;  // of the first failure
};

}  // namespace bip::rt
