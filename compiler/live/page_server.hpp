// HTTP and WebSocket on 127.0.0.1 for one live session. The only interface to Boost.Beast.
//
// Requests without the token, which is in the path of the page's address, get no answer. A page of another origin
// cannot drive the session: the `Host` of a request and the `Origin` of a WebSocket must be the server's own (a name
// that is resolved to 127.0.0.1 is none), and no answer allows another origin to read it. The first request that is not
// one of those that the page makes ends its connection. One thread serves all, and the session moves on the same one.
#pragma once
#include <cstdint>
#include <functional>
#include <string>

#include "compiler/base/result.hpp"
#include "compiler/live/page_session.hpp"

namespace bip::live {

struct PageServerOptions {
  std::uint16_t port = 0;                                  // 0: one that is free
  std::size_t max_clients = 16;                            // a new one takes the place of the oldest that is no page
  std::size_t max_head = 8 << 10, max_message = 64 << 10;  // bytes of a client
  std::size_t max_waiting = std::size_t{256} << 20;        // bytes to a client that does not read
  int silence = 10;                                        // seconds until a connection that asks for nothing is closed
};

/// Serves until SIGINT, SIGTERM or SIGHUP ends the process, the session's other end is gone, or standard input is a
/// pipe whose other end is closed. `page` makes the page, and gets what its content security policy allows it to
/// connect to; `announce` gets the page's address and returns whether anybody knows it now: nothing is served
/// otherwise. A failure says why nothing was served.
[[nodiscard]] Result<bool> serve_page(PageSession& session, const PageServerOptions& options,
                                      const std::function<std::string(const std::string& connects_to)>& page,
                                      const std::function<bool(const std::string& address)>& announce);

}  // namespace bip::live
