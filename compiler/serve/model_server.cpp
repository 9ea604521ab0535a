// See model_server.hpp. Clients are rows of a table. Handlers hold the row's number, not a pointer, so that a handler
// of a closed connection does nothing. A client is removed when no operation on its buffers is pending.
#include "compiler/serve/model_server.hpp"

#include <unistd.h>

#include <algorithm>
#include <asio.hpp>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "compiler/serve/protocol.hpp"

namespace bip::serve {

namespace {

namespace net = asio;
using Stream = net::posix::stream_descriptor;
// Requests of one client that the engine has not answered; its lines are read again when some are.
constexpr std::size_t kMaxAsked = 256;
// When no more connections can be opened: until one may have ended.
constexpr std::chrono::milliseconds kBreath{50};
// Notes on their way from the engine to the clients; what comes faster is dropped.
constexpr int kMaxNotes = 10000;

struct Client {
  Client(net::io_context& io, int from, int to) : in(io, from), out(io, to) {}
  Stream in, out;
  std::string received;
  std::deque<std::string> waiting;  // the first one is being written
  std::size_t waiting_bytes = 0;
  std::size_t asked = 0;  // requests without an answer so far
  std::uint64_t dropped = 0;
  bool is_subscribed = false;
  bool reads = false, writes = false, has_finished = false, is_closing = false, is_stdio = false;
};

class Server {
 public:
  Server(Controller& controller, const ServerOptions& options)
      : controller_(controller), options_(options), signals_(io_, SIGINT, SIGTERM) {}

  bool open(std::string& error) {
    std::error_code failed;
    if (!options_.socket_path.empty()) {
      ::unlink(options_.socket_path.c_str());
      local_.emplace(io_);
      const net::local::stream_protocol::endpoint at(options_.socket_path);
      if (!listen(*local_, at, failed)) {
        error = "cannot listen at `" + options_.socket_path + "`: " + failed.message();
        return false;
      }
      std::fprintf(stderr, "bipc: listening at %s\n", options_.socket_path.c_str());
      accept(*local_);
    }
    if (options_.uses_tcp) {
      tcp_.emplace(io_);
      const net::ip::tcp::endpoint at(net::ip::address_v4::loopback(), options_.tcp_port);
      if (!listen(*tcp_, at, failed)) {
        error = "cannot listen at port " + std::to_string(options_.tcp_port) + ": " + failed.message();
        return false;
      }
      std::fprintf(stderr, "bipc: listening at 127.0.0.1:%u\n",
                   static_cast<unsigned>(tcp_->local_endpoint(failed).port()));
      accept(*tcp_);
    }
    if (options_.uses_stdio) {
      Client& client = add(::dup(STDIN_FILENO), ::dup(STDOUT_FILENO));
      client.is_stdio = true;
    }
    return true;
  }

  void run() {
    signals_.async_wait([this](const std::error_code& failed, int) {
      if (!failed) io_.stop();
    });
    controller_.on_step = [this](const Step& step, std::int64_t now) { note(step, now); };
    controller_.on_end = [this](Outcome outcome, const std::string& text) {
      net::post(io_, [this, line = end_line(outcome, text)] { broadcast(nullptr, line); });
    };
    controller_.start();
    io_.run();
  }

 private:
  template <class Acceptor, class Endpoint>
  static bool listen(Acceptor& acceptor, const Endpoint& at, std::error_code& failed) {
    acceptor.open(at.protocol(), failed);
    if (!failed) acceptor.set_option(net::socket_base::reuse_address(true), failed);
    if (!failed) acceptor.bind(at, failed);
    if (!failed) acceptor.listen(16, failed);
    return !failed;
  }
  template <class Acceptor>
  void accept(Acceptor& acceptor) {
    acceptor.async_accept([this, &acceptor](const std::error_code& failed, auto socket) {
      if (failed == net::error::operation_aborted) return;
      if (failed) {
        // Too many open files, as a rule: to ask again at once would be all that this thread does.
        auto breath = std::make_unique<net::steady_timer>(io_, kBreath);
        breath->async_wait([this, &acceptor, held = std::move(breath)](const std::error_code&) { accept(acceptor); });
        return;
      }
      if (clients_.size() < options_.max_clients) {
        std::error_code ignored;
        const int file = socket.release(ignored);
        if (const int copy = ::dup(file); copy >= 0) add(file, copy);
        else ::close(file);
      }
      accept(acceptor);
    });
  }

  Client& add(int in, int out) {
    const std::uint64_t number = next_++;
    Client& client = *clients_.emplace(number, std::make_unique<Client>(io_, in, out)).first->second;
    client.in.non_blocking(true);
    client.out.non_blocking(true);
    read(number);
    return client;
  }

  // On the engine's thread: a step that nobody wants costs no line.
  void note(const Step& step, std::int64_t now) {
    std::vector<std::uint64_t> receivers;
    {
      const std::lock_guard<std::mutex> hold(subscriptions_lock_);
      for (const auto& [number, subscription] : subscriptions_) {
        if (subscription.wants(step)) receivers.push_back(number);
      }
    }
    if (receivers.empty()) return;
    if (notes_.fetch_add(1) >= kMaxNotes) {
      notes_.fetch_sub(1);
      lost_.fetch_add(1);
      return;
    }
    net::post(io_, [this, to = std::move(receivers), line = step_line(step, now)] {
      notes_.fetch_sub(1);
      broadcast(&to, line);
    });
  }

  // To some subscribers, or (null) to all.
  void broadcast(const std::vector<std::uint64_t>* to, const std::string& line) {
    const std::uint64_t lost = lost_.exchange(0);
    for (auto& [number, client] : clients_) {
      if (!client->is_subscribed) continue;
      client->dropped += lost;
      if (to != nullptr && std::find(to->begin(), to->end(), number) == to->end()) continue;
      if (client->waiting_bytes + line.size() > options_.max_waiting) {
        ++client->dropped;
        continue;
      }
      if (client->dropped != 0) {
        send(number, "{\"note\":\"dropped\",\"count\":" + std::to_string(client->dropped) + "}\n");
        client->dropped = 0;
      }
      send(number, line);
    }
  }

  void send(std::uint64_t number, std::string line) {
    const auto found = clients_.find(number);
    if (found == clients_.end() || found->second->is_closing) return;
    Client& client = *found->second;
    client.waiting_bytes += line.size();
    client.waiting.push_back(std::move(line));
    if (!client.writes) write(number, client);
  }

  void write(std::uint64_t number, Client& client) {
    client.writes = true;
    net::async_write(client.out, net::buffer(client.waiting.front()),
                     [this, number, &client](const std::error_code& failed, std::size_t) {
                       client.writes = false;
                       client.waiting_bytes -= client.waiting.front().size();
                       client.waiting.pop_front();
                       if (failed) return close(number, client);
                       if (!client.waiting.empty()) return write(number, client);
                       // Its answers are read: so are its lines again.
                       if (client.is_closing) close(number, client);
                       else read_on(number, client);
                     });
  }

  void read(std::uint64_t number) {
    Client& client = *clients_.at(number);
    client.reads = true;
    net::async_read_until(
        client.in, net::dynamic_buffer(client.received, options_.max_line), '\n',
        [this, number, &client](const std::error_code& failed, std::size_t size) {
          client.reads = false;
          if (client.is_closing) return close(number, client);
          if (failed == net::error::not_found) {
            send(number, error_line("a line is no longer than " + std::to_string(options_.max_line) + " bytes"));
            return finish(number, client);
          }
          if (failed) return finish(number, client);
          const std::string line = client.received.substr(0, size - 1);
          client.received.erase(0, size);
          if (line.find_first_not_of(" \t\r") != std::string::npos) handle(number, line);
          if (!clients_.contains(number) || client.is_closing) return;
          read_on(number, client);
        });
  }

  // The next line, unless the client has not read the answers to many, or many are still to be answered.
  void read_on(std::uint64_t number, const Client& client) {
    if (!client.reads && !client.has_finished && !client.is_closing && client.waiting_bytes < options_.max_waiting &&
        client.asked < kMaxAsked)
      read(number);
  }

  void answer(std::uint64_t number, std::string text) {
    const auto found = clients_.find(number);
    if (found == clients_.end()) return;
    --found->second->asked;
    send(number, std::move(text));
    read_on(number, *found->second);
  }

  void handle(std::uint64_t number, const std::string& line) {
    Reply reply;
    ++clients_.at(number)->asked;
    reply.send = [this, number](std::string text) {
      net::post(io_, [this, number, said = std::move(text)] { answer(number, said); });
    };
    reply.subscribe = [this, number](const Subscription& subscription) {
      clients_.at(number)->is_subscribed = subscription.is_on;
      forget(number);
      const std::lock_guard<std::mutex> hold(subscriptions_lock_);
      if (subscription.is_on) subscriptions_[number] = subscription;
    };
    reply.shut_down = [this] {
      ends_ = true;
      net::post(io_, [this] { net::post(io_, [this] { try_stop(); }); });
    };
    handle_line(controller_, line, std::move(reply));
  }

  // No more is read; what waits is still written. The engine is asked once more, so that answers on their way come
  // first.
  void finish(std::uint64_t number, Client& client) {
    client.has_finished = true;
    const bool ends_all = client.is_stdio && !local_ && !tcp_;
    controller_.ask([this, number, ends_all](Controller&) {
      net::post(io_, [this, number, ends_all] {
        ends_ = ends_ || ends_all;
        if (const auto found = clients_.find(number); found != clients_.end()) {
          found->second->is_closing = true;
          close(number, *found->second);
        }
        if (ends_) try_stop();
      });
    });
  }

  void close(std::uint64_t number, Client& client) {
    if (client.is_subscribed) forget(number);
    client.is_subscribed = false;
    client.is_closing = true;
    std::error_code ignored;
    if (client.reads) client.in.cancel(ignored);
    if (client.reads || client.writes) return;
    clients_.erase(number);
    if (ends_) try_stop();
  }

  void forget(std::uint64_t number) {
    const std::lock_guard<std::mutex> hold(subscriptions_lock_);
    subscriptions_.erase(number);
  }

  // Answers on their way are written first, if their clients read them at once. The answer to `shutdown` itself may
  // still be queued when another client's end comes here.
  void try_stop() {
    for (const auto& [number, client] : clients_) {
      const bool is_answered = client->asked == 0 && !client->writes;
      if (!is_answered && client->waiting_bytes < options_.max_waiting && ++patience_ < 1000) {
        net::post(io_, [this] { try_stop(); });
        return;
      }
    }
    io_.stop();
  }

  Controller& controller_;
  const ServerOptions& options_;
  net::io_context io_{1};
  net::signal_set signals_;
  std::optional<net::local::stream_protocol::acceptor> local_;
  std::optional<net::ip::tcp::acceptor> tcp_;
  std::map<std::uint64_t, std::unique_ptr<Client>> clients_;
  std::uint64_t next_ = 0;
  std::mutex subscriptions_lock_;
  std::map<std::uint64_t, Subscription> subscriptions_;  // read on the engine's thread
  std::atomic<int> notes_{0};
  std::atomic<std::uint64_t> lost_{0};
  bool ends_ = false;
  int patience_ = 0;
};

}  // namespace

bool serve(Controller& controller, const ServerOptions& options, std::string& error) {
  // A client that is gone is told by a failed write.
  std::signal(SIGPIPE, SIG_IGN);
  Server server(controller, options);
  if (!server.open(error)) return false;
  server.run();
  controller.halt();
  if (!options.socket_path.empty()) ::unlink(options.socket_path.c_str());
  return true;
}

}  // namespace bip::serve
