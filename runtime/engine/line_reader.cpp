// See line_reader.hpp.
#include "runtime/engine/line_reader.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>

#include "bip/assert.hpp"

namespace bip::rt {

namespace {
constexpr int kMostWait = 100;  // ms between two looks at is_stopped()
constexpr std::size_t kReadSize = std::size_t{1} << 16;
}  // namespace

LineReader::LineReader(const std::string& path, bool (*is_stopped)())
    : file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)), is_stopped_(is_stopped) {
  if (file_ < 0) open_error_ = errno;
}

LineReader::~LineReader() {
  if (file_ >= 0) ::close(file_);
}

// Line: there are more bytes.
LineReader::Got LineReader::fill() {
  buffer_.erase(0, at_);
  at_ = 0;
  const std::size_t before = buffer_.size();
  buffer_.resize(before + kReadSize);
  ssize_t size = -1;
  Got got = Got::Line;
  while (size < 0 && got == Got::Line) {
    if (is_stopped_ != nullptr && is_stopped_()) {
      got = Got::Stopped;
      break;
    }
    pollfd wanted{.fd = file_, .events = POLLIN, .revents = 0};
    const int ready = ::poll(&wanted, 1, kMostWait);
    if (ready == 0) continue;
    if (ready > 0) size = ::read(file_, buffer_.data() + before, kReadSize);
    if (size < 0 && errno != EINTR && errno != EAGAIN) got = Got::Failed;
  }
  if (size == 0) got = Got::End;
  buffer_.resize(before + (size > 0 ? static_cast<std::size_t>(size) : 0));
  return got;
}

LineReader::Got LineReader::next(std::string& line) {
  if (file_ < 0) {
    errno = open_error_;
    return Got::Failed;
  }
  BIP_ASSERT(!is_torn_, "a line after the last one");
  std::size_t looked = at_;
  while (true) {
    std::size_t end = buffer_.find('\n', looked);
    const bool has_newline = end != std::string::npos;
    if (!has_newline && buffer_.size() - at_ <= kMaxLine) {
      looked = buffer_.size() - at_;
      const Got got = fill();
      if (got == Got::Line) continue;
      if (got != Got::End || buffer_.empty()) return got;
      is_torn_ = true;
    }
    if (!has_newline) end = buffer_.size();
    line.assign(buffer_, at_, end - at_);
    at_ = end + (has_newline ? 1 : 0);
    return Got::Line;
  }
}

}  // namespace bip::rt
