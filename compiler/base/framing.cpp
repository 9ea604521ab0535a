// See framing.hpp. Cost: linear in the bytes; a body is copied once.
#include "compiler/base/framing.hpp"

#include <algorithm>
#include <charconv>
#include <cctype>

#include "runtime/include/bip/assert.hpp"

namespace bip {
namespace {

constexpr std::string_view kField = "content-length:";

bool begins_field(std::string_view line) {
  return line.size() >= kField.size() && std::equal(kField.begin(), kField.end(), line.begin(), [](char a, char b) {
           return a == static_cast<char>(std::tolower(static_cast<unsigned char>(b)));
         });
}

/// The length that a header's lines give; nullopt if there is none or two, or a line is no field. `is_whole`: all lines
/// are fields, so what is wrong is a value and no other header begins among them.
std::optional<std::size_t> length_of(std::string_view header, bool& too_long, bool& is_whole) {
  std::optional<std::size_t> length;
  bool is_good = true;
  is_whole = false;
  while (!header.empty()) {
    const std::size_t end = std::min(header.find('\n'), header.size());
    std::string_view line = header.substr(0, end);
    header.remove_prefix(std::min(end + 1, header.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.empty()) continue;
    if (line.find(':') == std::string_view::npos) return std::nullopt;
    if (!begins_field(line)) continue;
    line.remove_prefix(kField.size());
    while (line.starts_with(' ') || line.starts_with('\t')) line.remove_prefix(1);
    while (line.ends_with(' ') || line.ends_with('\t')) line.remove_suffix(1);
    std::size_t value = 0;
    const auto [stop, error] = std::from_chars(line.data(), line.data() + line.size(), value);
    too_long |= error == std::errc::result_out_of_range;
    is_good &= error == std::errc() && stop == line.data() + line.size() && !length;
    length = value;
  }
  is_whole = true;
  return is_good ? length : std::nullopt;
}

/// Where the empty line that ends a header is: its begin and the begin of the body.
std::optional<std::pair<std::size_t, std::size_t>> end_of_header(std::string_view text) {
  for (std::size_t at = text.find('\n'); at != std::string_view::npos; at = text.find('\n', at + 1)) {
    if (text.substr(at + 1).starts_with('\n')) return std::pair(at, at + 2);
    if (text.substr(at + 1).starts_with("\r\n")) return std::pair(at, at + 3);
    if (at > Framing::kMaxHeader) break;
  }
  return std::nullopt;
}

}  // namespace

bool Framing::drop_skipped() {
  const std::size_t now = std::min(skip_, buffer_.size());
  buffer_.erase(0, now);
  skip_ -= now;
  BIP_ASSERT(skip_ == 0 || buffer_.empty(), "{} bytes are to be skipped, {} are kept", skip_, buffer_.size());
  return skip_ == 0;
}

void Framing::resynchronise(std::size_t from) {
  lost_ = true;
  for (std::size_t at = from; at < buffer_.size(); ++at) {
    const bool begins = std::tolower(static_cast<unsigned char>(buffer_[at])) == kField[0];
    if (!begins) continue;
    const std::string_view rest = std::string_view(buffer_).substr(at, kField.size());
    // A field that is cut off by the end of what came so far may go on.
    const bool may_be = std::equal(rest.begin(), rest.end(), kField.begin(), [](char a, char b) {
      return static_cast<char>(std::tolower(static_cast<unsigned char>(a))) == b;
    });
    if (!may_be) continue;
    buffer_.erase(0, at);
    lost_ = rest.size() < kField.size();
    return;
  }
  buffer_.clear();
  BIP_ASSERT(lost_, "no header was found");
}

std::optional<Framing::Frame> Framing::next() {
  if (!drop_skipped()) return std::nullopt;
  if (lost_) resynchronise(0);
  if (lost_) return std::nullopt;
  const auto end = end_of_header(buffer_);
  if (!end) {
    if (buffer_.size() <= kMaxHeader) return std::nullopt;
    resynchronise(1);
    return Frame{Kind::BadHeader, {}};
  }
  bool too_long = false;
  bool is_whole = false;
  const auto length = length_of(std::string_view(buffer_).substr(0, end->first), too_long, is_whole);
  if (!length) {
    resynchronise(is_whole ? end->second : 1);
    return Frame{too_long ? Kind::TooLong : Kind::BadHeader, {}};
  }
  if (*length > kMaxBody) {
    buffer_.erase(0, end->second);
    skip_ = *length;
    (void)drop_skipped();
    return Frame{Kind::TooLong, {}};
  }
  if (buffer_.size() - end->second < *length) return std::nullopt;
  BIP_ASSERT(skip_ == 0 && !lost_, "a message is read while {} bytes are skipped", skip_);
  Frame frame{Kind::Message, buffer_.substr(end->second, *length)};
  buffer_.erase(0, end->second + *length);
  return frame;
}

std::size_t Framing::missing() const {
  if (skip_ > 0) return skip_;
  bool too_long = false;
  bool is_whole = false;
  if (const auto end = end_of_header(buffer_)) {
    const auto length = length_of(std::string_view(buffer_).substr(0, end->first), too_long, is_whole);
    if (length && *length <= kMaxBody && end->second + *length > buffer_.size())
      return end->second + *length - buffer_.size();
  }
  return 1;
}

std::string framed(std::string_view body) {
  return "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + std::string(body);
}

}  // namespace bip
