// Reads the lines of a file that may be a pipe or a FIFO; a wait for them can be interrupted.
//
// A signal does not end a read() that waits, nor an open() of a FIFO without a writer, because the handlers are
// installed with SA_RESTART. So the file is opened with O_NONBLOCK, and poll() waits. A signal ends poll(); a time
// limit of poll() covers a signal that another thread handled, or that came just before poll().
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>

namespace bip::rt {

class LineReader {
 public:
  /// Longer lines come in pieces, each longer than this but for the last.
  static constexpr std::size_t kMaxLine = std::size_t{1} << 20;
  /// Failed: errno says why. Stopped: is_stopped() held.
  enum class Got : std::uint8_t { Line, End, Failed, Stopped };

  /// `is_stopped` may be null: nothing ends a wait. If the file cannot be opened, the first next() is Failed.
  explicit LineReader(const std::string& path, bool (*is_stopped)() = nullptr);
  ~LineReader();
  LineReader(const LineReader&) = delete;
  LineReader& operator=(const LineReader&) = delete;

  /// The next line without its newline. Throws std::bad_alloc.
  [[nodiscard]] Got next(std::string& line);
  /// After Got::Line: it has no newline, the file ends there.
  [[nodiscard]] bool is_torn() const { return is_torn_; }

 private:
  [[nodiscard]] Got fill();

  int file_;
  int open_error_ = 0;
  bool (*is_stopped_)();
  bool is_torn_ = false;
  std::string buffer_;
  std::size_t at_ = 0;  // of the buffer: what was given out
};

}  // namespace bip::rt
