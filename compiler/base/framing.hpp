// Messages on a byte stream: `Content-Length: N`, an empty line, N bytes.
//
// Bytes are fed as they arrive, messages are taken when they are complete. A malformed header is skipped up to the next
// line that begins with `Content-Length:`, so that one bad message does not end the session. Lengths are limited; a
// longer message is skipped without being stored.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace bip {

class Framing {
 public:
  static constexpr std::size_t kMaxHeader = 4096;
  static constexpr std::size_t kMaxBody = 128u << 20;

  enum class Kind { Message, BadHeader, TooLong };
  struct Frame {
    Kind kind = Kind::Message;
    std::string body;
  };

  void feed(std::string_view bytes) { buffer_.append(bytes); }
  /// The next complete message, or the news that something was skipped. nullopt: more bytes are needed.
  [[nodiscard]] std::optional<Frame> next();
  /// Returns whether a message, or a part of one, has come that was not taken.
  [[nodiscard]] bool has_more() const { return !buffer_.empty(); }
  /// Bytes that a reader should ask for: what is known to be missing, at least 1.
  [[nodiscard]] std::size_t missing() const;

 private:
  [[nodiscard]] bool drop_skipped();
  void resynchronise(std::size_t from);

  std::string buffer_;
  std::size_t skip_ = 0;  // bytes of a body that was too long
  bool lost_ = false;     // looking for a header
};

[[nodiscard]] std::string framed(std::string_view body);

}  // namespace bip
