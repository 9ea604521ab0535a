// Access to a served model: tokens of TCP connections, the path and the peers of a Unix socket.
#pragma once
#include <string>
#include <string_view>

namespace bip::serve {

/// Returns 32 hexadecimal digits from the system's random numbers; empty if there are none.
[[nodiscard]] std::string make_token();

/// Compares in a time that does not depend on where the texts differ.
[[nodiscard]] bool is_token(std::string_view given, std::string_view token);

/// Returns whether the process at the other end of a Unix socket is of this user, or of root.
[[nodiscard]] bool is_own_peer(int socket);

/// A path at which a Unix socket may be made, and the socket that was made there.
class SocketPath {
 public:
  /// Removes a socket of this user at which no process listens, and nothing else. Returns why the path cannot be used;
  /// empty: nothing is there now.
  [[nodiscard]] std::string claim(const std::string& path);
  /// After the socket was bound: notes which file it is.
  void note_bound();
  /// Removes the file if it is still the one that was bound.
  void release() const;

 private:
  std::string path_;
  bool is_bound_ = false;
  unsigned long device_ = 0, file_ = 0;
};

/// Tells the service manager that clients can connect (READY=1 to $NOTIFY_SOCKET, sd_notify(3)), if there is one.
void notify_ready();

/// Returns whether the descriptor is a pipe or a socket whose other end is there: a parent that will close it.
[[nodiscard]] bool is_open_pipe(int descriptor);

}  // namespace bip::serve
