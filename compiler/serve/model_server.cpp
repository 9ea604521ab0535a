// See model_server.hpp. Clients are rows of a table. Handlers hold the row's number, not a pointer, so that a handler
// of a closed connection does nothing. A client is removed when no operation on its buffers is pending.
#include "compiler/serve/model_server.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <asio.hpp>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <tuple>
#include <vector>

#include "bip/assert.hpp"
#include "bip/result.hpp"
#include "compiler/serve/access.hpp"
#include "compiler/serve/protocol.hpp"
#include "runtime/core/text.hpp"

namespace bip::serve {

namespace {

namespace net = asio;
using Stream = net::posix::stream_descriptor;
// Requests of one client that the engine has not answered; its lines are read again when some are.
constexpr std::size_t kMaxAsked = 256;
// When no more connections can be opened: until one may have ended.
constexpr std::chrono::milliseconds kBreath{50};
// Between two looks for connections to be closed, unless they are to be closed sooner.
constexpr std::chrono::nanoseconds kSweep = std::chrono::seconds(1);
// How long the answers that are due at the end may take.
constexpr std::chrono::seconds kLastAnswers{2};
// Notes on their way from the engine to the clients; what comes faster is dropped.
constexpr std::size_t kMaxNotes = 10000;

using ServerClock = std::chrono::steady_clock;
/// Where a client comes from. Peers of a Unix socket are checked by the system, those of TCP by their token.
enum class Origin : std::uint8_t { Stdio, Local, Tcp };
/// Who wants a place when all are taken. Stranger: a connection of TCP before its token. LowerRole: an observer or a
/// requester of TCP by its token. Owner: a connection to the Unix socket, which is the user's own.
enum class Newcomer : std::uint8_t { Stranger, LowerRole, Owner };

struct Client {
  Client(net::io_context& io, int from, int to) : in(io, from), out(io, to) {}
  Stream in, out;
  [[nodiscard]] std::size_t waiting_bytes() const { return written.size() + waiting.size(); }
  std::string received;
  std::string written, waiting;  // lines: those that are being written, and those after them
  std::size_t asked = 0;         // requests without an answer so far
  std::uint64_t dropped = 0;
  bool is_subscribed = false, hears_requests = false, has_breakpoint = false;
  bool reads = false, writes = false, has_finished = false, is_closing = false;
  Origin origin = Origin::Stdio;
  Role role = Role::Operator;
  bool is_known = false;    // its requests are executed; a client of TCP is by its token
  bool has_spoken = false;  // a request was understood
  bool asks = false;        // for services, or posts events
  ServerClock::time_point last_request = ServerClock::now();
};

/// What clients hear of a step of the model.
struct StepNote {
  enum class Kind : std::uint8_t {
    Step,  // dropped if the clients do not keep up
    Break  // the model pauses after it
  };
  std::vector<std::uint64_t> receivers;
  std::string line;
  Kind kind;
};

// Reading from a terminal must not stay non-blocking for the shell after us.
class SavedDescriptorFlags {
 public:
  explicit SavedDescriptorFlags(int descriptor) : descriptor_(descriptor), flags_(::fcntl(descriptor, F_GETFL)) {}
  ~SavedDescriptorFlags() {
    if (flags_ >= 0) ::fcntl(descriptor_, F_SETFL, flags_);
  }
  SavedDescriptorFlags(const SavedDescriptorFlags&) = delete;
  SavedDescriptorFlags& operator=(const SavedDescriptorFlags&) = delete;

 private:
  int descriptor_, flags_;
};

class Server {
 public:
  Server(Controller& controller, const ServerOptions& options)
      : controller_(controller),
        options_(options),
        signals_(io_, SIGINT, SIGTERM, SIGHUP),
        sweep_(io_),
        silence_(io_) {}

  ~Server() { socket_path_.release(); }
  /// After run(): what went wrong on standard input or output; empty: nothing.
  [[nodiscard]] const std::string& problem() const { return problem_; }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  Result<bool> open() {
    std::error_code failed;
    if (!options_.socket_path.empty()) {
      const std::string problem = open_local();
      if (!problem.empty()) return Failure{"cannot listen at `" + options_.socket_path + "`: " + problem};
      std::fprintf(stderr, "bipc: listening at %s\n", rt::printable(options_.socket_path).c_str());
      accept(*local_);
    }
    if (options_.uses_tcp) {
      tcp_.emplace(io_);
      const net::ip::tcp::endpoint at(net::ip::address_v4::loopback(), options_.tcp_port);
      if (!listen(*tcp_, at, failed))
        return Failure{"cannot listen at port " + std::to_string(options_.tcp_port) + ": " + failed.message()};
      for (std::string& token : tokens_) {
        token = make_token();
        if (token.empty()) return Failure{"the system has no random numbers for a token"};
      }
      std::fprintf(stderr,
                   "bipc: listening at 127.0.0.1:%u\nbipc: token %s\nbipc: token of requesters %s\n"
                   "bipc: token of observers %s\n",
                   static_cast<unsigned>(tcp_->local_endpoint(failed).port()), token_of(Role::Operator).c_str(),
                   token_of(Role::Requester).c_str(), token_of(Role::Observer).c_str());
      accept(*tcp_);
    }
    if (options_.uses_stdio) {
      for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO}) kept_flags_.emplace_back(descriptor);
      add(::dup(STDIN_FILENO), ::dup(STDOUT_FILENO), Origin::Stdio);
    } else {
      watches_parent_ = is_open_pipe(STDIN_FILENO);
    }
    sweep();
    notify_ready();
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
    controller_.on_alarm() = [this](const Alarm& alarm) { note(alarm); };
    controller_.requests().on_reply = [this](const RequestReply& reply) { note(reply); };
    controller_.start();
    io_.run();
  }

 private:
  // The file has the mode of the socket's descriptor from its first moment on. Empty, or what is wrong.
  std::string open_local() {
    if (std::string problem = socket_path_.claim(options_.socket_path); !problem.empty()) return problem;
    std::error_code failed;
    local_.emplace(io_);
    try {
      const net::local::stream_protocol::endpoint at(options_.socket_path);
      local_->open(at.protocol(), failed);
      if (!failed && ::fchmod(local_->native_handle(), 0600) != 0)
        failed = std::error_code(errno, std::generic_category());
      if (!failed) local_->bind(at, failed);
      if (!failed) local_->listen(16, failed);
    } catch (const std::system_error& error) {
      failed = error.code();
    }
    if (failed) return failed.message();
    socket_path_.note_bound();
    return {};
  }

  // Ends with the parent that started us with a pipe and is gone, and closes connections that have said nothing for too
  // long. Nothing is read from the pipe.
  void sweep() {
    if (watches_parent_ && !is_open_pipe(STDIN_FILENO)) return io_.stop();
    const ServerClock::time_point now = ServerClock::now();
    const std::chrono::nanoseconds silence(options_.close_after);
    std::vector<std::uint64_t> silent;
    for (const auto& [number, client] : clients_) {
      if (client->origin != Origin::Stdio && !client->has_spoken && now - client->last_request > silence)
        silent.push_back(number);
    }
    for (const std::uint64_t number : silent) close(number, *clients_.at(number));
    sweep_.expires_after(std::min(kSweep, silence));
    sweep_.async_wait([this](const std::error_code& failed) {
      if (!failed) sweep();
    });
  }

  [[nodiscard]] bool may_go(const Client& client, Newcomer newcomer, ServerClock::time_point now) const {
    if (client.origin == Origin::Stdio || client.is_closing) return false;
    const bool is_at_work = client.is_subscribed || client.asked != 0;
    const bool is_idle = !is_at_work && now - client.last_request > std::chrono::nanoseconds(options_.idle_after);
    switch (newcomer) {
      case Newcomer::Stranger: return is_idle || (!client.has_spoken && !is_at_work);
      case Newcomer::LowerRole: return is_idle && client.is_known && client.role != Role::Operator;
      case Newcomer::Owner: return !is_at_work || client.role != Role::Operator;
    }
    BIP_UNREACHABLE("a newcomer of no kind");
  }

  // Frees a place: one that never sent a line goes first, then the idlest of a lower role, then the idlest operator.
  // False: all stay.
  bool make_room(Newcomer newcomer) {
    const ServerClock::time_point now = ServerClock::now();
    const auto order = [](const Client& client) {
      return std::tuple(client.has_spoken, client.role == Role::Operator, client.last_request);
    };
    std::optional<std::uint64_t> first;
    for (const auto& [number, client] : clients_) {
      if (may_go(*client, newcomer, now) && (!first || order(*client) < order(*clients_.at(*first)))) first = number;
    }
    if (!first) return false;
    close(*first, *clients_.at(*first));
    return true;
  }

  // Has an observer or a requester that has just shown its token a place beside the others of such roles?
  bool has_place(const Client& newcomer) {
    BIP_ASSERT(options_.kept_for_operators < options_.max_clients, "{} places of {} are kept",
               options_.kept_for_operators, options_.max_clients);
    const auto others = std::count_if(clients_.begin(), clients_.end(), [&](const auto& row) {
      const Client& client = *row.second;
      return &client != &newcomer && client.is_known && !client.is_closing && client.role != Role::Operator;
    });
    return static_cast<std::size_t>(others) < options_.max_clients - options_.kept_for_operators ||
           make_room(Newcomer::LowerRole);
  }

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
      constexpr bool is_local = std::is_same_v<Acceptor, net::local::stream_protocol::acceptor>;
      constexpr Newcomer newcomer = is_local ? Newcomer::Owner : Newcomer::Stranger;
      if (failed) {
        // Too many open files, as a rule: to ask again at once would be all that this thread does.
        (void)make_room(Newcomer::Stranger);
        auto breath = std::make_unique<net::steady_timer>(io_, kBreath);
        breath->async_wait([this, &acceptor, held = std::move(breath)](const std::error_code&) { accept(acceptor); });
        return;
      }
      const bool may_enter = !is_local || is_own_peer(socket.native_handle());
      if (may_enter && (clients_.size() < options_.max_clients || make_room(newcomer))) {
        std::error_code ignored;
        const int file = socket.release(ignored);
        if (const int copy = ::dup(file); copy >= 0) add(file, copy, is_local ? Origin::Local : Origin::Tcp);
        else ::close(file);
      }
      accept(acceptor);
    });
  }

  void add(int in, int out, Origin origin) {
    const std::uint64_t number = next_++;
    Client& client = *clients_.emplace(number, std::make_unique<Client>(io_, in, out)).first->second;
    client.origin = origin;
    client.is_known = origin != Origin::Tcp;
    client.in.non_blocking(true);
    client.out.non_blocking(true);
    read(number);
  }

  // On the engine's thread: a step that no client watches costs no line.
  void note(const Step& step, std::int64_t now) {
    now_.store(now, std::memory_order_relaxed);
    if (step.interaction.empty()) return;  // nobody followed when it began
    std::vector<std::uint64_t> receivers, breakers;
    {
      const std::lock_guard<std::mutex> hold(watched_lock_);
      for (const auto& [number, watched] : watched_) {
        if (watched.told.wants(step)) receivers.push_back(number);
        if (watched.breaks.wants(step)) breakers.push_back(number);
      }
    }
    if (!breakers.empty()) {
      controller_.pause();
      hand_over({std::move(breakers), step_line(step, now, "break"), StepNote::Kind::Break});
    }
    if (!receivers.empty()) hand_over({std::move(receivers), step_line(step, now), StepNote::Kind::Step});
  }

  // From the engine's thread to ours. One handler takes all notes that have come meanwhile: with a handler a note, a
  // fast model fills the queue of handlers, and requests and writes wait at its end.
  void hand_over(StepNote note) {
    const std::lock_guard<std::mutex> hold(notes_lock_);
    if (note.kind == StepNote::Kind::Step && notes_.size() >= kMaxNotes) {
      lost_.fetch_add(1);
      return;
    }
    notes_.push_back(std::move(note));
    if (notes_.size() == 1) net::post(io_, [this] { take_over(); });
  }
  void take_over() {
    std::vector<StepNote> notes;
    {
      const std::lock_guard<std::mutex> hold(notes_lock_);
      notes.swap(notes_);
    }
    BIP_ASSERT(!notes.empty(), "a handler without notes");
    for (const StepNote& note : notes) {
      switch (note.kind) {
        case StepNote::Kind::Step: broadcast(&note.receivers, note.line); break;
        case StepNote::Kind::Break:
          for (const std::uint64_t number : note.receivers) send(number, note.line);
          break;
      }
    }
  }

  // With watched_lock_ held: steps have names while a client follows them.
  void name_steps() {
    controller_.name_all_steps(std::any_of(watched_.begin(), watched_.end(), [](const auto& row) {
      return row.second.told.is_on || row.second.breaks.is_on;
    }));
  }

  // Any thread: to who asked, and to who wants to hear of all requests.
  void note(const RequestReply& reply) {
    net::post(io_, [this, client = reply.client, line = request_line(reply, now_.load())] {
      for (auto& [number, to] : clients_) {
        if (number != client && !to->hears_requests) continue;
        if (to->waiting_bytes() + line.size() > options_.max_waiting) ++to->dropped;
        else send(number, line);
      }
    });
  }

  // Any thread: in the log, and, if clients are to hear of it, to all who subscribed to anything.
  void note(const Alarm& alarm) {
    const char* const code = alarm.kind == Alarm::Kind::Late      ? "R0047"
                             : alarm.kind == Alarm::Kind::Stopped ? "R0049"
                                                                  : "R0046";
    std::fprintf(stderr, "warning[%s]: %s\n", code, alarm.text.c_str());
    if (alarm.is_told) net::post(io_, [this, line = alarm_line(alarm)] { broadcast(nullptr, line); });
  }

  // To some subscribers, or (null: the end) to all and to those who wait at a breakpoint.
  void broadcast(const std::vector<std::uint64_t>* to, const std::string& line) {
    const std::uint64_t lost = lost_.exchange(0);
    for (auto& [number, client] : clients_) {
      if (!client->is_subscribed && !(to == nullptr && client->has_breakpoint)) continue;
      client->dropped += lost;
      if (to != nullptr && std::find(to->begin(), to->end(), number) == to->end()) continue;
      if (client->waiting_bytes() + line.size() > options_.max_waiting) {
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

  void send(std::uint64_t number, const std::string& line) {
    const auto found = clients_.find(number);
    if (found == clients_.end() || found->second->is_closing) return;
    Client& client = *found->second;
    client.waiting += line;
    if (!client.writes) write(number, client);
  }

  void write(std::uint64_t number, Client& client) {
    BIP_ASSERT(!client.writes && !client.waiting.empty(), "client {} is written to already, or nothing waits", number);
    client.writes = true;
    client.written.swap(client.waiting);
    net::async_write(client.out, net::buffer(client.written),
                     [this, number, &client](const std::error_code& failed, std::size_t) {
                       client.writes = false;
                       // The reader of our standard output is gone, and with it the only client.
                       ends_ = ends_ || (failed && is_only_client(client));
                       if (failed != net::error::broken_pipe)
                         note_stream_failure(client, "write standard output", failed);
                       client.written.clear();
                       if (failed) return close(number, client);
                       if (!client.waiting.empty()) return write(number, client);
                       // Its answers are read: so are its lines again.
                       if (client.is_closing) return close(number, client);
                       read_on(number, client);
                       if (ends_) try_stop();
                     });
  }

  void read(std::uint64_t number) {
    Client& client = *clients_.at(number);
    BIP_ASSERT(!client.reads && !client.is_closing, "client {} is read already, or closes", number);
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
          if (failed != net::error::eof) note_stream_failure(client, "read standard input", failed);
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
    if (!client.reads && !client.has_finished && !client.is_closing && client.waiting_bytes() < options_.max_waiting &&
        client.asked < kMaxAsked)
      read(number);
  }

  void answer(std::uint64_t number, const std::string& text) {
    const auto found = clients_.find(number);
    if (found == clients_.end()) return;
    BIP_ASSERT(found->second->asked > 0, "an answer that client {} has not asked for", number);
    --found->second->asked;
    send(number, text);
    read_on(number, *found->second);
    if (ends_) try_stop();
  }

  // Of standard input and output; connections of others fail as they like.
  void note_stream_failure(const Client& client, const char* what, const std::error_code& failed) {
    if (!failed || failed == net::error::operation_aborted || client.origin != Origin::Stdio || !problem_.empty())
      return;
    problem_ = std::string("cannot ") + what + ": " + failed.message();
  }

  [[nodiscard]] bool is_only_client(const Client& client) const {
    return client.origin == Origin::Stdio && !local_ && !tcp_;
  }

  // A client of TCP begins with `hello` and the token; what is no protocol of ours, such as a web page's, ends it.
  bool may_ask(std::uint64_t number, Client& client, const std::string& line) {
    if (client.origin != Origin::Tcp) return true;
    const LineKind kind = kind_of_line(line);
    if (kind == LineKind::NoObject) {
      close(number, client);
      return false;
    }
    if (client.is_known) return true;
    const std::string given = token_of_hello(line);
    for (const Role role : {Role::Observer, Role::Requester, Role::Operator}) {
      if (!is_token(given, token_of(role))) continue;
      if (role != Role::Operator && !has_place(client)) {
        send(number, error_line("all places for observers and requesters are taken"));
        finish(number, client);
        return false;
      }
      client.role = role;
      return client.is_known = true;
    }
    send(number, error_line("the first request is `hello` with the `token` that the server printed"));
    finish(number, client);
    return false;
  }

  // The decisional level has spoken.
  void hear_asker() {
    if (options_.silent_after <= 0) return;
    silence_.expires_after(std::chrono::nanoseconds(options_.silent_after));
    silence_.async_wait([this](const std::error_code& failed) {
      if (failed) return;
      controller_.stop_robot("the decisional level has been silent for " +
                             std::to_string(options_.silent_after / 1'000'000) + " ms");
    });
  }

  [[nodiscard]] std::string& token_of(Role role) { return tokens_[static_cast<std::size_t>(role)]; }

  void handle(std::uint64_t number, const std::string& line) {
    Client& client = *clients_.at(number);
    if (!may_ask(number, client, line)) return;
    client.last_request = ServerClock::now();
    client.has_spoken = client.has_spoken || kind_of_line(line) == LineKind::Object;
    client.asks = client.asks || (client.role >= Role::Requester && is_asking(line));
    if (client.asks) hear_asker();
    Reply reply;
    reply.client = number;
    reply.role = client.role;
    reply.take_role = [&client](Role role) { client.role = role; };
    ++client.asked;
    reply.send = [this, number](std::string text) {
      net::post(io_, [this, number, said = std::move(text)] { answer(number, said); });
    };
    reply.subscribe = [this, number](const Subscription& subscription) {
      clients_.at(number)->is_subscribed = subscription.is_on || subscription.hears_requests;
      clients_.at(number)->hears_requests = subscription.hears_requests;
      const std::lock_guard<std::mutex> hold(watched_lock_);
      watched_[number].told = subscription;
      name_steps();
    };
    reply.break_at = [this, number](const Subscription& steps) {
      clients_.at(number)->has_breakpoint = steps.is_on;
      const std::lock_guard<std::mutex> hold(watched_lock_);
      watched_[number].breaks = steps;
      name_steps();
    };
    // After the answers to all requests that the engine has before this one.
    reply.shut_down = [this] { controller_.ask([this](Controller&) { net::post(io_, [this] { begin_end(); }); }); };
    handle_line(controller_, line, std::move(reply));
  }

  // No more is read; what waits is still written. The engine is asked once more, so that answers on their way come
  // first.
  void finish(std::uint64_t number, Client& client) {
    client.has_finished = true;
    const bool ends_all = is_only_client(client);
    controller_.ask([this, number, ends_all](Controller&) {
      net::post(io_, [this, number, ends_all] {
        if (ends_all) begin_end();
        if (const auto found = clients_.find(number); found != clients_.end()) {
          found->second->is_closing = true;
          close(number, *found->second);
        }
        if (ends_) try_stop();
      });
    });
  }

  void close(std::uint64_t number, Client& client) {
    {
      const std::lock_guard<std::mutex> hold(watched_lock_);
      watched_.erase(number);
      name_steps();
    }
    client.is_subscribed = false;
    client.is_closing = true;
    std::error_code ignored;
    if (client.reads) client.in.cancel(ignored);
    if (client.reads || client.writes) return;
    BIP_ASSERT(!watched_.contains(number), "client {} leaves its subscription behind", number);
    clients_.erase(number);
    controller_.requests().leave(number);
    if (ends_) try_stop();
  }

  // Answers on their way are written first, if their clients read them in time.
  void begin_end() {
    if (!last_answers_) {
      last_answers_.emplace(io_, kLastAnswers);
      last_answers_->async_wait([this](const std::error_code&) { io_.stop(); });
    }
    ends_ = true;
    try_stop();
  }

  // Called again whenever an answer was written.
  void try_stop() {
    for (const auto& [number, client] : clients_) {
      const bool is_answered = client->asked == 0 && !client->writes;
      if (!is_answered && client->waiting_bytes() < options_.max_waiting) return;
    }
    io_.stop();
  }

  Controller& controller_;
  const ServerOptions& options_;
  net::io_context io_{1};
  net::signal_set signals_;
  net::steady_timer sweep_, silence_;
  std::optional<net::steady_timer> last_answers_;
  std::deque<SavedDescriptorFlags> kept_flags_;
  SocketPath socket_path_;
  std::array<std::string, 3> tokens_;  // of TCP, by role
  std::string problem_;
  std::optional<net::local::stream_protocol::acceptor> local_;
  std::optional<net::ip::tcp::acceptor> tcp_;
  std::map<std::uint64_t, std::unique_ptr<Client>> clients_;
  std::uint64_t next_ = 0;
  /// The steps that a client watches, and those after which the model pauses for it.
  struct Watched {
    Subscription told, breaks;
  };
  std::mutex watched_lock_;
  std::map<std::uint64_t, Watched> watched_;  // by client; read on the engine's thread
  std::atomic<std::int64_t> now_{0};          // of the last step
  std::mutex notes_lock_;
  std::vector<StepNote> notes_;  // no more than kMaxNotes, and breaks
  std::atomic<std::uint64_t> lost_{0};
  bool ends_ = false;
  bool watches_parent_ = false;
};

}  // namespace

ServeResult serve(Controller& controller, const ServerOptions& options) {
  // A failed write shows that the client is gone.
  std::signal(SIGPIPE, SIG_IGN);
  Server server(controller, options);
  if (const Result<bool> opened = server.open(); !opened) return {ServeEnd::NotOpened, opened.error()};
  server.run();
  controller.halt();
  return {server.problem().empty() ? ServeEnd::Done : ServeEnd::StreamFailed, server.problem()};
}

}  // namespace bip::serve
