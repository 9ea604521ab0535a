// Connections of clients to a running model: standard input, a Unix socket, TCP on the loopback. The only folder that
// includes asio.
//
// One thread serves all clients and never blocks on one of them. Output that a client does not read is buffered up to a
// limit; beyond it notes are dropped and counted, and the client's requests are not read until it has read the answers.
// The length of a line is limited. Connections that say nothing are closed; a client of TCP needs a token (access.hpp).
// Places are limited, and neither strangers nor clients of lower roles can take all of them: see Newcomer in the .cpp.
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "compiler/serve/controller.hpp"

namespace bip::serve {

struct ServerOptions {
  bool uses_stdio = true;
  std::string socket_path;  // empty: none
  bool uses_tcp = false;
  std::uint16_t tcp_port = 0;  // 0: one that is free
  /// The robot is stopped when a client that has asked for services or posted events sends nothing for so long (ns); 0:
  /// never.
  std::int64_t silent_after = 0;
  std::size_t max_line = 1 << 16;
  std::size_t max_waiting = 1 << 20;  // bytes to a client
  std::size_t max_clients = 64;
  /// Of these: those that observers and requesters of TCP never take, together. Fewer than max_clients.
  std::size_t kept_for_operators = 4;
  /// A connection that has said nothing sound for so long (ns) is closed.
  std::int64_t close_after = 10'000'000'000;
  /// When all places are taken, one that was idle for so long (ns) makes room for anybody.
  std::int64_t idle_after = 60'000'000'000;
};

/// StreamFailed: an error ended standard input or output, over which the model was served.
enum class ServeEnd : std::uint8_t { Done, NotOpened, StreamFailed };
struct ServeResult {
  ServeEnd end = ServeEnd::Done;
  std::string problem;  // what could not be opened, or what failed; empty: Done
};

/// Until a client says `shutdown`, standard input ends (if it is served and nothing else is, or if it is a pipe), or
/// SIGINT, SIGTERM or SIGHUP come. Prints on standard error where it listens, and the tokens of TCP clients.
[[nodiscard]] ServeResult serve(Controller& controller, const ServerOptions& options);

}  // namespace bip::serve
