// A relay between processes that talk over TCP, and what goes wrong there: delays, stalls, cuts, resets, by a seed.
//
//   relay SEED FROM_ADDRESS:PORT=TO_ADDRESS:PORT …       IPv4; each is a link, numbered from 0
//
// Lines on standard input (a link is its number or `all`):
//   delay MS           what comes from now on arrives so much later
//   spin US            keeps its processor for so long before something is due: then no timer makes it late
//   cut LINK MS        nothing passes for so long; connections stay; 0 ends a cut
//   break LINK MS      connections are reset, and nobody connects for so long
//   faults N MS        N random ones, one each so many milliseconds on average; then `done N` is written
//   report             writes `late MEAN MOST` since the last report: microseconds from when something was due to when
//                      it was sent
// A delay counts from when the system received the bytes, so that the time until this process has woken up is a part of
// it. Ends with its input. Within a connection bytes keep their order, as TCP promises; over connections they do not.
#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <list>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace {

using Ns = std::int64_t;
constexpr Ns kMs = 1000000;
constexpr std::size_t kMostHeld = std::size_t{1} << 22;  // bytes of a direction

Ns ns_of(const timespec& time) { return Ns{time.tv_sec} * 1000000000 + time.tv_nsec; }

Ns now_ns(clockid_t clock = CLOCK_MONOTONIC) {
  timespec time{};
  clock_gettime(clock, &time);
  return ns_of(time);
}

// Receives bytes, and when the system received them: at most `now`, and that if it does not tell.
ssize_t receive(int file, char* bytes, std::size_t size, Ns now, Ns& at) {
  iovec part{bytes, size};
  alignas(cmsghdr) std::array<char, 256> extra;
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = extra.data();
  message.msg_controllen = extra.size();
  const ssize_t received = recvmsg(file, &message, 0);
  at = now;
  if (received <= 0) return received;
  for (cmsghdr* each = CMSG_FIRSTHDR(&message); each != nullptr; each = CMSG_NXTHDR(&message, each)) {
    if (each->cmsg_level != SOL_SOCKET || each->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec stamp{};
    std::memcpy(&stamp, CMSG_DATA(each), sizeof stamp);
    at = std::min(now, now_ns() - (now_ns(CLOCK_REALTIME) - ns_of(stamp)));
  }
  return received;
}

struct Piece {
  Ns due;
  bool is_begun;  // a part of it was sent
  std::string bytes;
};
struct Direction {
  std::deque<Piece> pieces;
  std::size_t held = 0;
};
struct Connection {
  std::size_t link;
  std::array<int, 2> files;
  std::array<Direction, 2> directions;  // from files[k]
};
struct Link {
  int listener = -1;
  sockaddr_in to{};
  Ns cut_until = 0, broken_until = 0, later = 0;
};

sockaddr_in address_of(const std::string& text) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  const std::size_t colon = text.rfind(':');
  address.sin_port = htons(static_cast<std::uint16_t>(std::atoi(text.c_str() + colon + 1)));
  if (colon == std::string::npos || inet_pton(AF_INET, text.substr(0, colon).c_str(), &address.sin_addr) != 1) {
    std::fprintf(stderr, "relay: `%s` is no ADDRESS:PORT\n", text.c_str());
    std::exit(2);
  }
  return address;
}

class Relay {
 public:
  explicit Relay(std::uint64_t seed) : draws_(seed) {}

  bool add(const std::string& from, const std::string& to) {
    Link link;
    link.to = address_of(to);
    const sockaddr_in at = address_of(from);
    const int on = 1;
    link.listener = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    setsockopt(link.listener, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (bind(link.listener, reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0 || listen(link.listener, 8) != 0) {
      std::perror("relay");
      return false;
    }
    links_.push_back(link);
    return true;
  }

  void run() {
    while (!ends_) {
      const Ns now = now_ns();
      make_faults(now);
      pass_on(now);
      wait(now);
    }
  }

 private:
  Ns below(Ns bound) { return static_cast<Ns>(draws_() % static_cast<std::uint64_t>(bound)); }

  // Not closed in order: what is on its way is lost.
  static void reset(Connection& connection) {
    const linger hard{1, 0};
    for (int& file : connection.files) {
      if (file < 0) continue;
      setsockopt(file, SOL_SOCKET, SO_LINGER, &hard, sizeof hard);
      close(file);
      file = -1;
    }
  }

  void break_link(std::size_t k, Ns until) {
    links_[k].broken_until = until;
    for (Connection& connection : connections_) {
      if (connection.link == k) reset(connection);
    }
  }

  void make_faults(Ns now) {
    if (faults_left_ == 0 || now < next_fault_) return;
    const std::size_t k = static_cast<std::size_t>(below(static_cast<Ns>(links_.size())));
    switch (below(4)) {
      case 0: links_[k].cut_until = now + below(300 * kMs); break;
      case 1: break_link(k, now); break;
      case 2: break_link(k, now + below(300 * kMs)); break;
      default: links_[k].later = below(20 * kMs); break;
    }
    next_fault_ = now + 1 + below(2 * fault_interval_);
    if (--faults_left_ != 0) return;
    for (Link& link : links_) link.later = 0;
    std::printf("done %llu\n", static_cast<unsigned long long>(faults_));
    std::fflush(stdout);
  }

  [[nodiscard]] bool is_cut(std::size_t k, Ns now) const { return now < links_[k].cut_until; }

  // Writes what is due.
  void pass_on(Ns now) {
    for (Connection& connection : connections_) {
      for (std::size_t side = 0; side < 2 && !is_cut(connection.link, now); ++side) {
        Direction& direction = connection.directions[side];
        while (connection.files[0] >= 0 && !direction.pieces.empty() && direction.pieces.front().due <= now) {
          std::string& bytes = direction.pieces.front().bytes;
          const Ns late = now_ns() - direction.pieces.front().due;
          const ssize_t done = send(connection.files[1 - side], bytes.data(), bytes.size(), MSG_NOSIGNAL);
          if (done < 0 && (errno == EAGAIN || errno == EINPROGRESS || errno == ENOTCONN)) break;
          if (done < 0) {
            reset(connection);
            break;
          }
          if (!std::exchange(direction.pieces.front().is_begun, true)) note_late(late);
          direction.held -= static_cast<std::size_t>(done);
          bytes.erase(0, static_cast<std::size_t>(done));
          if (bytes.empty()) direction.pieces.pop_front();
        }
      }
    }
    connections_.remove_if([](const Connection& connection) { return connection.files[0] < 0; });
  }

  void take(Connection& connection, std::size_t side, Ns now) {
    std::array<char, 65536> bytes;
    Ns at = now;
    const ssize_t size = receive(connection.files[side], bytes.data(), bytes.size(), now, at);
    if (size < 0 && errno == EAGAIN) return;
    if (size <= 0) return reset(connection);
    Direction& direction = connection.directions[side];
    Ns due = at + delay_ + links_[connection.link].later;
    if (!direction.pieces.empty()) due = std::max(due, direction.pieces.back().due);
    direction.pieces.push_back({due, false, std::string(bytes.data(), static_cast<std::size_t>(size))});
    direction.held += static_cast<std::size_t>(size);
  }

  void accept_at(std::size_t k, Ns now) {
    Link& link = links_[k];
    const int file = accept4(link.listener, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (file < 0) return;
    const int on = 1;
    Connection connection{k, {file, socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)}, {}};
    for (const int each : connection.files) {
      setsockopt(each, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      setsockopt(each, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
    }
    const bool is_refused =
        now < link.broken_until ||
        (connect(connection.files[1], reinterpret_cast<const sockaddr*>(&link.to), sizeof link.to) != 0 &&
         errno != EINPROGRESS);
    if (is_refused) return reset(connection);
    connections_.push_back(std::move(connection));
  }

  void note_late(Ns ns) {
    ++sent_;
    late_ += ns;
    latest_ = std::max(latest_, ns);
  }

  void report() {
    const auto us = [](Ns ns) { return static_cast<double>(ns) / 1000; };
    std::printf("late %.1f %.1f\n", us(late_) / static_cast<double>(std::max<Ns>(sent_, 1)), us(latest_));
    std::fflush(stdout);
    sent_ = late_ = latest_ = 0;
  }

  void command(const std::string& line) {
    std::istringstream words(line);
    std::string what, which;
    Ns ms = 0;
    words >> what;
    if (what == "delay") {
      double each = 0;
      words >> each;
      delay_ = static_cast<Ns>(each * kMs);
    } else if (what == "spin") {
      words >> spin_;
      spin_ *= 1000;
    } else if (what == "report") {
      report();
    } else if (what == "faults") {
      words >> faults_ >> ms;
      faults_left_ = faults_;
      fault_interval_ = std::max<Ns>(ms, 1) * kMs;
      next_fault_ = now_ns();
    } else if (what == "cut" || what == "break") {
      words >> which >> ms;
      const Ns until = now_ns() + ms * kMs;
      for (std::size_t k = 0; k < links_.size(); ++k) {
        if (which != "all" && std::to_string(k) != which) continue;
        if (what == "cut") links_[k].cut_until = until;
        else break_link(k, until);
      }
    }
  }

  void read_commands() {
    std::array<char, 4096> bytes;
    const ssize_t size = read(STDIN_FILENO, bytes.data(), bytes.size());
    if (size <= 0) ends_ = true;
    else input_.append(bytes.data(), static_cast<std::size_t>(size));
    for (std::size_t end = input_.find('\n'); end != std::string::npos; end = input_.find('\n')) {
      command(input_.substr(0, end));
      input_.erase(0, end + 1);
    }
  }

  void wait(Ns now) {
    Ns due = now + 1000 * kMs;
    if (faults_left_ != 0) due = std::min(due, next_fault_);
    polled_.assign(1, {STDIN_FILENO, POLLIN, 0});
    for (const Link& link : links_) polled_.push_back({link.listener, POLLIN, 0});
    for (const Connection& connection : connections_) {
      const Link& link = links_[connection.link];
      const bool is_held = is_cut(connection.link, now);
      if (is_held) due = std::min(due, link.cut_until);
      for (std::size_t side = 0; side < 2; ++side) {
        short events = connection.directions[side].held < kMostHeld && !is_held ? POLLIN : 0;
        const Direction& back = connection.directions[1 - side];
        if (!back.pieces.empty() && !is_held) {
          if (back.pieces.front().due <= now) events |= POLLOUT;
          else due = std::min(due, back.pieces.front().due);
        }
        polled_.push_back({connection.files[side], events, 0});
      }
    }
    // A timer of the system is late; what remains is waited for by looking at the clock.
    const Ns left = std::max<Ns>(due - spin_ - now_ns(), 0);
    const timespec time{left / 1000000000, left % 1000000000};
    if (ppoll(polled_.data(), polled_.size(), &time, nullptr) <= 0) return;
    const Ns then = now_ns();
    std::size_t row = 1 + links_.size();
    for (Connection& connection : connections_) {
      for (std::size_t side = 0; side < 2; ++side, ++row) {
        if (connection.files[side] < 0) continue;
        if ((polled_[row].revents & POLLIN) != 0) take(connection, side, then);
        else if ((polled_[row].revents & (POLLERR | POLLHUP)) != 0) reset(connection);
      }
    }
    connections_.remove_if([](const Connection& connection) { return connection.files[0] < 0; });
    for (std::size_t k = 0; k < links_.size(); ++k) {
      if ((polled_[1 + k].revents & POLLIN) != 0) accept_at(k, then);
    }
    if (polled_[0].revents != 0) read_commands();
  }

  std::mt19937_64 draws_;
  std::vector<Link> links_;
  std::list<Connection> connections_;
  std::vector<pollfd> polled_;
  std::string input_;
  Ns delay_ = 0, spin_ = 0, next_fault_ = 0, fault_interval_ = kMs;
  Ns sent_ = 0, late_ = 0, latest_ = 0;  // pieces since the last report
  std::uint64_t faults_ = 0, faults_left_ = 0;
  bool ends_ = false;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  prctl(PR_SET_TIMERSLACK, 1);
  Relay relay(std::strtoull(argv[1], nullptr, 10));
  for (int k = 2; k < argc; ++k) {
    const std::string link = argv[k];
    const std::size_t equals = link.find('=');
    if (equals == std::string::npos || !relay.add(link.substr(0, equals), link.substr(equals + 1))) return 2;
  }
  std::puts("ready");
  std::fflush(stdout);
  relay.run();
}
