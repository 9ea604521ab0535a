// Connections of clients to a running model: standard input, a Unix socket, TCP on the loopback. The only folder that
// includes asio.
//
// One thread serves all clients and never blocks on one of them. Output that a client does not read is buffered up to a
// limit; beyond it notes are dropped and counted, and the client's requests are not read until it has read the answers.
// The length of a line is limited.
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
  std::size_t max_line = 1 << 16;
  std::size_t max_waiting = 1 << 20;  // bytes to a client
  std::size_t max_clients = 64;
};

/// Until a client says `shutdown`, standard input ends (if it is served and nothing else is), or SIGINT or SIGTERM
/// come. False: `error` says what could not be opened. Tells where it listens on standard error.
[[nodiscard]] bool serve(Controller& controller, const ServerOptions& options, std::string& error);

}  // namespace bip::serve
