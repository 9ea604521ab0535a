// See page_server.hpp. Connections are rows of a table. Handlers hold the row's number, not a pointer, so that a
// handler of a closed connection does nothing. A connection is removed when no operation on it is pending.
#include "compiler/live/page_server.hpp"

#include <unistd.h>

// Before Boost.Asio 1.74, which uses it without including it.
#include <utility>

#include <algorithm>
#include <array>
#include <boost/asio.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <csignal>
#include <deque>
#include <map>
#include <memory>
#include <optional>

#include "bip/assert.hpp"
#include "compiler/serve/access.hpp"

namespace bip::live {

namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace net = boost::asio;
namespace websocket = beast::websocket;
using Tcp = net::ip::tcp;
using Failure = beast::error_code;
// How often a session with another end is woken.
constexpr std::chrono::milliseconds kTick{25};
// When no more connections can be opened: until one may have ended.
constexpr std::chrono::milliseconds kBreath{50};
// How often the parent's pipe is looked at.
constexpr std::chrono::seconds kSweep{1};

struct Connection {
  explicit Connection(Tcp::socket&& socket) : stream(std::in_place, std::move(socket)) {}
  // Moved into the WebSocket when there is one.
  std::optional<beast::tcp_stream> stream;
  std::optional<websocket::stream<beast::tcp_stream>> pipe;
  beast::flat_buffer received;
  std::optional<http::request_parser<http::empty_body>> parser;
  http::response<http::string_body> response;
  std::deque<std::string> waiting;  // the first one is being written
  std::size_t waiting_bytes = 0, pending = 0;
  bool is_closed = false, is_page = false;
};

class PageServer {
 public:
  PageServer(PageSession& session, const PageServerOptions& options,
             const std::function<std::string(const std::string&)>& page)
      : session_(session),
        options_(options),
        page_(page),
        acceptor_(io_),
        signals_(io_),
        clock_(io_),
        sweep_(io_),
        breath_(io_) {}

  // The page's address.
  Result<std::string> open() {
    Failure failed;
    const Tcp::endpoint at(net::ip::address_v4::loopback(), options_.port);
    if (!acceptor_.open(at.protocol(), failed)) acceptor_.set_option(net::socket_base::reuse_address(true), failed);
    if (!failed) acceptor_.bind(at, failed);
    if (!failed) acceptor_.listen(net::socket_base::max_listen_connections, failed);
    if (failed) return bip::Failure{"cannot listen at port " + std::to_string(options_.port) + ": " + failed.message()};
    token_ = serve::make_token();
    if (token_.empty()) return bip::Failure{"the system has no random numbers for a token"};
    const std::string port = std::to_string(acceptor_.local_endpoint(failed).port());
    hosts_ = {"127.0.0.1:" + port, "localhost:" + port};
    session_.send = [this](std::uint64_t page, const std::string& message) { send(page, message); };
    session_.send_to_all = [this](const std::string& message) {
      for (const auto& [number, connection] : connections_)
        if (connection->is_page) send(number, message);
    };
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) signals_.add(signal, failed);
    signals_.async_wait([this](const Failure& why, int) {
      if (!why) io_.stop();
    });
    accept();
    if (serve::is_open_pipe(STDIN_FILENO)) sweep();
    if (session_.descriptor() >= 0) {
      model_.emplace(io_, ::dup(session_.descriptor()));
      wait_for_model();
      tick();
    }
    return "http://" + hosts_[0] + "/" + token_ + "/";
  }

  void run() { io_.run(); }

 private:
  // What the session is attached to has said something, or is gone.
  void wait_for_model() {
    model_->async_wait(net::posix::stream_descriptor::wait_read, [this](const Failure& failed) {
      if (failed == net::error::operation_aborted) return;
      if (failed || !session_.hear()) return io_.stop();
      wait_for_model();
    });
  }
  void tick() {
    clock_.expires_after(kTick);
    clock_.async_wait([this](const Failure& failed) {
      if (failed) return;
      if (!session_.tick()) return io_.stop();
      tick();
    });
  }

  // Ends with the parent that started us with a pipe and is gone. Nothing is read from the pipe.
  void sweep() {
    if (!serve::is_open_pipe(STDIN_FILENO)) return io_.stop();
    sweep_.expires_after(kSweep);
    sweep_.async_wait([this](const Failure& failed) {
      if (!failed) sweep();
    });
  }

  // Frees a place for a new connection: the oldest that is no page goes. False: all are pages.
  bool make_room() {
    for (const auto& [number, connection] : connections_) {
      if (connection->is_page || connection->is_closed) continue;
      close(number);
      return true;
    }
    return false;
  }

  void accept() {
    acceptor_.async_accept([this](const Failure& failed, Tcp::socket socket) {
      if (failed == net::error::operation_aborted) return;
      if (failed) {
        // Too many open files, as a rule: to ask again at once would be all that this thread does.
        (void)make_room();
        breath_.expires_after(kBreath);
        breath_.async_wait([this](const Failure& stopped) {
          if (!stopped) accept();
        });
        return;
      }
      // One too many is closed at once.
      if (connections_.size() < options_.max_clients || make_room()) {
        const std::uint64_t number = next_++;
        Connection& c = *connections_.emplace(number, std::make_unique<Connection>(std::move(socket))).first->second;
        read_request(number, c);
      }
      accept();
    });
  }

  Connection* find(std::uint64_t number) {
    const auto found = connections_.find(number);
    return found == connections_.end() ? nullptr : found->second.get();
  }
  // An operation of the connection has ended: nothing if the connection is closed, and it is removed with the last.
  Connection* ended(std::uint64_t number) {
    Connection* const c = find(number);
    if (c == nullptr) return nullptr;
    BIP_ASSERT(c->pending > 0, "connection {} ends an operation that it has not begun", number);
    --c->pending;
    if (!c->is_closed) return c;
    if (c->pending == 0) connections_.erase(number);
    return nullptr;
  }
  void close(std::uint64_t number) {
    Connection* const c = find(number);
    if (c == nullptr || c->is_closed) return;
    c->is_closed = true;
    beast::tcp_stream& stream = c->pipe ? beast::get_lowest_layer(*c->pipe) : *c->stream;
    Failure ignored;
    stream.socket().shutdown(Tcp::socket::shutdown_both, ignored);
    stream.close();
    const bool was_page = std::exchange(c->is_page, false);
    if (was_page) session_.leave(number);
    // A handler that is on its way removes it; else this does, but not under the feet of the caller.
    if (c->pending == 0) net::post(io_, [this, number] { connections_.erase(number); });
  }

  // -- HTTP --

  void read_request(std::uint64_t number, Connection& c) {
    c.parser.emplace();
    c.parser->header_limit(static_cast<std::uint32_t>(options_.max_head));
    c.parser->body_limit(0);
    c.stream->expires_after(std::chrono::seconds(options_.silence));
    ++c.pending;
    http::async_read_header(*c.stream, c.received, *c.parser, [this, number](const Failure& failed, std::size_t) {
      Connection* const open = ended(number);
      if (open == nullptr) return;
      if (failed) return close(number);
      answer(number, *open);
    });
  }

  void answer(std::uint64_t number, Connection& c) {
    const http::request<http::empty_body>& request = c.parser->get();
    const auto text = [](const auto& part) { return std::string_view(part.data(), part.size()); };
    const std::string_view host = text(request[http::field::host]), target = text(request.target());
    const bool is_sound = request.method() == http::verb::get && request.version() == 11 && !c.parser->chunked() &&
                          request.count(http::field::host) == 1 && !request.has_content_length() &&
                          c.received.size() == 0 && std::find(hosts_.begin(), hosts_.end(), host) != hosts_.end();
    if (!is_sound) return respond(number, c, http::status::bad_request, {});
    const bool has_token = target.size() >= token_.size() + 2 && target[0] == '/' && target[token_.size() + 1] == '/' &&
                           serve::is_token(target.substr(1, token_.size()), token_);
    if (!has_token) return respond(number, c, http::status::not_found, {});
    const std::string_view rest = target.substr(token_.size() + 2);
    const std::string origin = "http://" + std::string(host);
    const bool is_upgrade = websocket::is_upgrade(request);
    if (rest.empty() && !is_upgrade) {
      const auto [page, is_new] = pages_.try_emplace(std::string(host));
      if (is_new) page->second = page_("ws://" + page->first);
      return respond(number, c, http::status::ok, page->second);
    }
    if (rest != "live" || !is_upgrade) return respond(number, c, http::status::not_found, {});
    if (request.count(http::field::origin) != 1 || text(request[http::field::origin]) != origin)
      return respond(number, c, http::status::forbidden, {});
    upgrade(number, c);
  }

  // One answer a connection.
  void respond(std::uint64_t number, Connection& c, http::status status, std::string body) {
    BIP_ASSERT(c.stream && c.pending == 0, "connection {} is answered while {} operations are under way", number,
               c.pending);
    c.response = {};
    c.response.version(11);
    c.response.result(status);
    c.response.set(http::field::content_type, "text/html; charset=utf-8");
    c.response.set(http::field::cache_control, "no-store");
    c.response.set("Referrer-Policy", "no-referrer");
    c.response.set("X-Content-Type-Options", "nosniff");
    c.response.set("X-Frame-Options", "DENY");
    c.response.set("Content-Security-Policy", "frame-ancestors 'none'");
    c.response.set("Cross-Origin-Resource-Policy", "same-origin");
    c.response.set("Cross-Origin-Opener-Policy", "same-origin");
    c.response.keep_alive(false);
    c.response.body() = std::move(body);
    c.response.prepare_payload();
    c.stream->expires_after(std::chrono::seconds(options_.silence));
    ++c.pending;
    http::async_write(*c.stream, c.response, [this, number](const Failure&, std::size_t) {
      if (ended(number) != nullptr) close(number);
    });
  }

  // -- WebSocket --

  void upgrade(std::uint64_t number, Connection& c) {
    c.stream->expires_never();
    c.pipe.emplace(std::move(*c.stream));
    c.stream.reset();
    c.pipe->set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
    c.pipe->read_message_max(options_.max_message);
    c.pipe->text(true);
    ++c.pending;
    c.pipe->async_accept(c.parser->get(), [this, number](const Failure& failed) {
      Connection* const open = ended(number);
      if (open == nullptr) return;
      if (failed) return close(number);
      open->is_page = true;
      session_.greet(number);
      if (Connection* const still = find(number); still != nullptr && !still->is_closed) read(number, *still);
    });
  }

  void read(std::uint64_t number, Connection& c) {
    BIP_ASSERT(c.pipe && c.is_page && !c.is_closed, "connection {} is no open page", number);
    c.received.clear();
    ++c.pending;
    c.pipe->async_read(c.received, [this, number](const Failure& failed, std::size_t) {
      Connection* const open = ended(number);
      if (open == nullptr) return;
      if (failed || !open->pipe->got_text()) return close(number);
      const net::const_buffer bytes = open->received.data();
      const std::string message(static_cast<const char*>(bytes.data()), bytes.size());
      if (!session_.handle(number, message)) return close(number);
      if (session_.is_running()) go_on();
      if (Connection* const still = find(number); still != nullptr && !still->is_closed) read(number, *still);
    });
  }

  void send(std::uint64_t number, const std::string& message) {
    Connection* const c = find(number);
    if (c == nullptr || c->is_closed || !c->is_page) return;
    if (c->waiting_bytes + message.size() > options_.max_waiting) return close(number);
    c->waiting_bytes += message.size();
    c->waiting.push_back(message);
    if (c->waiting.size() == 1) write(number, *c);
  }
  void write(std::uint64_t number, Connection& c) {
    BIP_ASSERT(c.pipe && !c.waiting.empty(), "nothing waits for connection {}", number);
    ++c.pending;
    c.pipe->async_write(net::buffer(c.waiting.front()), [this, number](const Failure& failed, std::size_t) {
      Connection* const open = ended(number);
      if (open == nullptr) return;
      if (failed) return close(number);
      BIP_ASSERT(open->waiting_bytes >= open->waiting.front().size(), "{} bytes wait, {} are written",
                 open->waiting_bytes, open->waiting.front().size());
      open->waiting_bytes -= open->waiting.front().size();
      open->waiting.pop_front();
      if (!open->waiting.empty()) write(number, *open);
    });
  }

  // A slice of a walk or a run; then the sockets are looked at.
  void go_on() {
    if (is_going_) return;
    is_going_ = true;
    net::post(io_, [this] {
      is_going_ = false;
      session_.go_on();
      if (session_.is_interrupted()) return io_.stop();
      if (session_.is_running()) go_on();
    });
  }

  PageSession& session_;
  const PageServerOptions options_;
  const std::function<std::string(const std::string&)>& page_;
  net::io_context io_{1};
  Tcp::acceptor acceptor_;
  net::signal_set signals_;
  net::steady_timer clock_, sweep_, breath_;
  std::optional<net::posix::stream_descriptor> model_;
  std::string token_;
  std::array<std::string, 2> hosts_;
  std::map<std::string, std::string> pages_;  // by host
  std::map<std::uint64_t, std::unique_ptr<Connection>> connections_;
  std::uint64_t next_ = 1;
  bool is_going_ = false;
};

}  // namespace

Result<bool> serve_page(PageSession& session, const PageServerOptions& options,
                        const std::function<std::string(const std::string& connects_to)>& page,
                        const std::function<bool(const std::string& address)>& announce) {
  PageServer server(session, options, page);
  const Result<std::string> address = server.open();
  if (!address) return bip::Failure{address.error()};
  if (announce(*address)) server.run();
  return true;
}

}  // namespace bip::live
