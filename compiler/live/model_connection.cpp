// See model_connection.hpp.
#include "compiler/live/model_connection.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>

#include "bip/assert.hpp"

namespace bip::live {

namespace {

bool is_digits(const std::string& text) {
  return !text.empty() && text.size() <= 5 && text.find_first_not_of("0123456789") == std::string::npos;
}

std::string problem_of(int error) { return std::strerror(error); }

}  // namespace

Result<std::unique_ptr<ModelConnection>> ModelConnection::open(const std::string& where, const std::string& token) {
  const std::string port = where.substr(0, where.find(':'));
  const bool is_port = is_digits(port);
  std::string used;
  int descriptor = -1, failed = 0;
  if (is_port) {
    used = port.size() < where.size() ? where.substr(port.size() + 1) : token;
    const unsigned long number = std::stoul(port);
    if (number == 0 || number > 65535) return Failure{"a port is a number from 1 to 65535"};
    if (used.empty()) return Failure{"a port needs the token that `bipc serve` printed: `PORT:TOKEN`, or $BIPC_TOKEN"};
    descriptor = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_port = htons(static_cast<std::uint16_t>(number));
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (descriptor < 0 || ::connect(descriptor, reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0) failed = errno;
  } else {
    sockaddr_un at{};
    at.sun_family = AF_UNIX;
    if (where.empty() || where.size() >= sizeof at.sun_path)
      return Failure{"the path of a socket is shorter than that"};
    std::copy(where.begin(), where.end(), at.sun_path);
    descriptor = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (descriptor < 0 || ::connect(descriptor, reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0) failed = errno;
  }
  if (failed == 0 && ::fcntl(descriptor, F_SETFL, O_NONBLOCK) != 0) failed = errno;
  if (failed != 0) {
    if (descriptor >= 0) ::close(descriptor);
    return Failure{problem_of(failed)};
  }
  return std::make_unique<ModelConnection>(descriptor, std::move(used));
}

ModelConnection::~ModelConnection() { ::close(descriptor_); }

bool ModelConnection::send(const std::string& line) {
  BIP_ASSERT(line.find('\n') == std::string::npos, "a request of {} bytes in several lines", line.size());
  if (waiting_.size() + line.size() > kMostWaiting) return false;
  waiting_ += line + '\n';
  return flush();
}

bool ModelConnection::flush() {
  std::size_t sent = 0;
  bool is_open = true;
  while (sent < waiting_.size()) {
    const ssize_t count = ::send(descriptor_, waiting_.data() + sent, waiting_.size() - sent, MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      is_open = errno == EAGAIN || errno == EWOULDBLOCK;
      break;
    }
    sent += static_cast<std::size_t>(count);
  }
  BIP_ASSERT(sent <= waiting_.size(), "{} of {} bytes were sent", sent, waiting_.size());
  waiting_.erase(0, sent);
  return is_open;
}

bool ModelConnection::receive(std::vector<std::string>& lines) {
  lines.insert(lines.end(), early_.begin(), early_.end());
  early_.clear();
  bool is_open = true;
  while (true) {
    char buffer[65536];
    const ssize_t count = ::recv(descriptor_, buffer, sizeof buffer, 0);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) break;
    is_open = count > 0 && received_.size() < kMostReceived;
    if (!is_open) break;
    received_.append(buffer, static_cast<std::size_t>(count));
  }
  std::size_t at = 0;
  for (std::size_t end = 0; (end = received_.find('\n', at)) != std::string::npos; at = end + 1)
    lines.push_back(received_.substr(at, end - at));
  received_.erase(0, at);
  return is_open;
}

std::optional<std::string> ModelConnection::wait_for_line(int seconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
  while (true) {
    std::vector<std::string> lines;
    const bool is_open = receive(lines);
    if (!lines.empty()) {
      early_.assign(lines.begin() + 1, lines.end());
      return lines.front();
    }
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    if (!is_open || left.count() <= 0) return std::nullopt;
    pollfd waits{descriptor_, POLLIN, 0};
    (void)::poll(&waits, 1, static_cast<int>(left.count()));
  }
}

}  // namespace bip::live
