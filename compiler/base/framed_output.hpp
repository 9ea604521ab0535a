// Writes messages with their length to a descriptor, as language servers and debug adapters do, and keeps the first
// error: after it nothing more is written, for a message that was cut off cannot be followed by another one.
#pragma once
#include <string_view>

namespace bip {

class FramedOutput {
 public:
  /// The descriptor stays the caller's.
  explicit FramedOutput(int file) : file_(file) {}
  /// Writes all of the message, unless an earlier one has failed.
  void write(std::string_view body);
  /// Returns the error's number of the message that could not be written; 0: all were.
  [[nodiscard]] int error() const { return error_; }

 private:
  int file_;
  int error_ = 0;
};

}  // namespace bip
