// See access.hpp.
#include "compiler/serve/access.hpp"

#include <poll.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>

#include "bip/assert.hpp"

namespace bip::serve {

namespace {

// False: the path is too long for a socket.
bool address_of(const std::string& path, sockaddr_un& address) {
  address = {};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) return false;
  std::memcpy(address.sun_path, path.data(), path.size());
  return true;
}

// A socket at which no process listens refuses connections.
bool is_dead_socket(const std::string& path) {
  sockaddr_un address{};
  if (!address_of(path, address)) return false;
  const int probe = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (probe < 0) return false;
  const bool is_dead =
      ::connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 && errno == ECONNREFUSED;
  ::close(probe);
  return is_dead;
}

}  // namespace

std::string make_token() {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) return {};
  std::string token;
  for (const unsigned byte : bytes) {
    token += "0123456789abcdef"[byte >> 4];
    token += "0123456789abcdef"[byte & 15];
  }
  return token;
}

bool is_token(std::string_view given, std::string_view token) {
  unsigned difference = given.size() == token.size() && !token.empty() ? 0 : 1;
  for (std::size_t k = 0; k < given.size(); ++k)
    difference |= static_cast<unsigned char>(given[k]) ^ static_cast<unsigned char>(k < token.size() ? token[k] : '\0');
  return difference == 0;
}

bool is_own_peer(int socket) {
  ucred peer{};
  socklen_t size = sizeof peer;
  return ::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0 && (peer.uid == ::geteuid() || peer.uid == 0);
}

std::string SocketPath::claim(const std::string& path) {
  path_ = path;
  struct stat found {};
  if (::lstat(path.c_str(), &found) != 0) return errno == ENOENT ? std::string() : std::strerror(errno);
  if (!S_ISSOCK(found.st_mode)) return "there is a file that is no socket";
  if (found.st_uid != ::geteuid()) return "there is a socket of another user";
  if (!is_dead_socket(path)) return "another process listens there already";
  return ::unlink(path.c_str()) == 0 ? std::string() : std::strerror(errno);
}

void SocketPath::note_bound() {
  BIP_ASSERT(!path_.empty() && !is_bound_, "a socket without a path, or a second one");
  struct stat made {};
  is_bound_ = ::lstat(path_.c_str(), &made) == 0;
  device_ = made.st_dev;
  file_ = made.st_ino;
}

void SocketPath::release() const {
  struct stat found {};
  if (is_bound_ && ::lstat(path_.c_str(), &found) == 0 && found.st_dev == device_ && found.st_ino == file_)
    ::unlink(path_.c_str());
}

void notify_ready() {
  const char* const where = std::getenv("NOTIFY_SOCKET");
  sockaddr_un address{};
  if (where == nullptr || (*where != '/' && *where != '@') || !address_of(where, address)) return;
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + std::strlen(where));
  // A name of the abstract namespace begins with a zero byte.
  if (*where == '@') address.sun_path[0] = '\0';
  const int socket = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket < 0) return;
  constexpr std::string_view kReady = "READY=1";
  (void)::sendto(socket, kReady.data(), kReady.size(), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&address), size);
  ::close(socket);
}

bool is_open_pipe(int descriptor) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0 || !(S_ISFIFO(status.st_mode) || S_ISSOCK(status.st_mode))) return false;
  pollfd end{.fd = descriptor, .events = POLLIN, .revents = 0};
  return ::poll(&end, 1, 0) >= 0 && (end.revents & (POLLHUP | POLLERR)) == 0;
}

}  // namespace bip::serve
