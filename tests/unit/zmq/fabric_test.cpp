// The fabric of ZeroMQ sockets: who may connect, what is refused, and links that lose nothing while a relay between
// them delays, stalls, resets and cuts connections.
#include <catch2/catch.hpp>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#include <zmq.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstring>
#include <thread>

#include "bip/prng.hpp"
#include "compiler/zmq/zmq_fabric.hpp"
#include "runtime/core/core.hpp"
#include "runtime/distributed/station.hpp"
#include "tests/unit/runtime/models.hpp"

using namespace bip;
using namespace bip::rt;

namespace {

/// For what has to happen, in ns.
constexpr std::int64_t kPatience = 60'000'000'000;
constexpr int kPatienceMs = 60'000;

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

// A port that nobody has now.
int free_port() {
  const int file = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  REQUIRE(::bind(file, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
  socklen_t size = sizeof address;
  ::getsockname(file, reinterpret_cast<sockaddr*>(&address), &size);
  ::close(file);
  return ntohs(address.sin_port);
}
std::string address_of(int port) { return "tcp://127.0.0.1:" + std::to_string(port); }

// Two processes' plans; the second connects to the first through `port`.
std::array<FabricPlan, 2> plans_of_two(int listens, int port) {
  const std::array<FabricKeys, 2> keys{zmq_fabric::make_keys(), zmq_fabric::make_keys()};
  std::array<FabricPlan, 2> plans;
  for (std::uint32_t self = 0; self < 2; ++self)
    plans[self] = {self, {address_of(self == 0 ? listens : port), ""}, {keys[0].open, keys[1].open}, keys[self]};
  return plans;
}

std::unique_ptr<Fabric> opened(const FabricPlan& plan) {
  Result<std::unique_ptr<Fabric>> fabric = zmq_fabric::open(plan);
  INFO((fabric ? "" : fabric.error()));
  REQUIRE(fabric);
  return std::move(*fabric);
}

// What comes within the time, at least one if there is any.
std::vector<Arrival> heard_by(Fabric& fabric, int ms) {
  std::vector<Arrival> arrivals;
  for (const std::int64_t end = now_ns() + std::int64_t{ms} * 1000000; arrivals.empty() && now_ns() < end;)
    (void)fabric.wait(20, {}, arrivals);
  return arrivals;
}

// The same, of bytes that are said again and again: what is sent before there is a connection is lost.
std::vector<Arrival> heard_of(Fabric& from, std::uint32_t to, const std::string& bytes, Fabric& by, int ms) {
  std::vector<Arrival> arrivals;
  for (const std::int64_t end = now_ns() + std::int64_t{ms} * 1000000; arrivals.empty() && now_ns() < end;) {
    from.send(to, bytes);
    arrivals = heard_by(by, 50);
  }
  return arrivals;
}

// Carries bytes between one who connects and one who listens, and does harm to them.
class Relay {
 public:
  Relay(int port, int to, std::uint64_t seed) : to_(to), draws_(seed) {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0);
    const int on = 1;
    ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    sockaddr_in address = loopback(port);
    REQUIRE(::bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
    REQUIRE(::listen(listener_, 8) == 0);
    thread_ = std::thread([this] { carry(); });
  }
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;
  ~Relay() {
    ends_ = true;
    thread_.join();
    reset();
    ::close(listener_);
  }
  std::atomic<bool> is_calm{false};
  [[nodiscard]] std::uint64_t faults() const { return faults_; }

 private:
  static sockaddr_in loopback(int port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
  }
  void reset() {
    // Not closed in order: what is on its way is lost.
    const linger hard{1, 0};
    for (int& file : files_) {
      if (file < 0) continue;
      ::setsockopt(file, SOL_SOCKET, SO_LINGER, &hard, sizeof hard);
      ::close(file);
      file = -1;
    }
  }
  void pass(int from, int to) {
    std::array<char, 4096> bytes;
    const ssize_t size = ::read(from, bytes.data(), 1 + draws_.below(bytes.size()));
    if (size <= 0) return reset();
    for (ssize_t done = 0; done < size;) {
      const ssize_t now = ::write(to, bytes.data() + done, static_cast<std::size_t>(size - done));
      if (now < 0) return reset();
      done += now;
    }
  }
  void carry() {
    while (!ends_) {
      if (!is_calm && draws_.below(40) == 0) {
        ++faults_;
        switch (draws_.below(3)) {
          case 0: std::this_thread::sleep_for(std::chrono::milliseconds(draws_.below(20))); break;
          case 1: reset(); break;
          default:
            reset();
            std::this_thread::sleep_for(std::chrono::milliseconds(draws_.below(60)));
            break;
        }
      }
      if (files_[0] < 0) {
        files_[0] = ::accept(listener_, nullptr, nullptr);
        if (files_[0] >= 0) {
          files_[1] = ::socket(AF_INET, SOCK_STREAM, 0);
          sockaddr_in address = loopback(to_);
          if (::connect(files_[1], reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) reset();
        }
      }
      if (files_[0] < 0) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        continue;
      }
      std::array<pollfd, 2> polled{{{files_[0], POLLIN, 0}, {files_[1], POLLIN, 0}}};
      if (::poll(polled.data(), 2, 2) <= 0) continue;
      for (std::size_t k = 0; k < 2; ++k) {
        if (files_[0] >= 0 && (polled[k].revents & (POLLIN | POLLHUP)) != 0) pass(files_[k], files_[1 - k]);
      }
    }
  }

  int to_;
  Prng draws_;
  int listener_ = -1;
  std::array<int, 2> files_{-1, -1};
  std::atomic<bool> ends_{false};
  std::atomic<std::uint64_t> faults_{0};
  std::thread thread_;
};

}  // namespace

TEST_CASE("bytes come whole, from the peer whose key was shown") {
  const int port = free_port();
  const auto plans = plans_of_two(port, port);
  const auto first = opened(plans[0]), second = opened(plans[1]);
  const std::string bytes("a\0b", 3);
  const std::vector<Arrival> arrivals = heard_of(*second, 0, bytes, *first, kPatienceMs);
  REQUIRE(!arrivals.empty());
  CHECK(arrivals[0].from == 1);
  CHECK(arrivals[0].bytes == bytes);
  first->send(1, std::string(100000, 'x'));
  const std::vector<Arrival> answers = heard_by(*second, kPatienceMs);
  REQUIRE(answers.size() == 1);
  CHECK(answers[0].from == 0);
  CHECK(answers[0].bytes.size() == 100000);
  CHECK(first->counts().refused == 0);
}

TEST_CASE("who is far behind gets portions, and all of it") {
  constexpr std::size_t kFrames = 400, kSize = 10000;
  const int port = free_port();
  const auto plans = plans_of_two(port, port);
  const auto first = opened(plans[0]), second = opened(plans[1]);
  REQUIRE(!heard_of(*second, 0, "is there", *first, kPatienceMs).empty());
  for (std::size_t n = 0; n < kFrames; ++n) second->send(0, std::string(kSize, static_cast<char>('a' + n % 26)));
  // Until the last one has come to the socket of the first.
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  std::size_t frames = 0, largest = 0;
  for (const std::int64_t end = now_ns() + kPatience; frames < kFrames && now_ns() < end;) {
    std::size_t bytes = 0;
    for (const Arrival& arrival : heard_by(*first, 1000)) {
      if (arrival.bytes == "is there") continue;
      CHECK(arrival.bytes == std::string(kSize, static_cast<char>('a' + frames % 26)));
      ++frames;
      bytes += arrival.bytes.size();
    }
    largest = std::max(largest, bytes);
  }
  CHECK(frames == kFrames);
  CHECK(largest < kFrames * kSize / 4);
}

TEST_CASE("who has another key is refused and counted, and hears nothing") {
  const int port = free_port();
  auto plans = plans_of_two(port, port);
  const auto first = opened(plans[0]);
  plans[1].keys = zmq_fabric::make_keys();
  const auto stranger = opened(plans[1]);
  CHECK(heard_of(*stranger, 0, "let me in", *first, 400).empty());
  first->send(1, "a secret");
  CHECK(heard_by(*stranger, 200).empty());
  // A busy machine needs more time than these for a connection.
  for (const std::int64_t end = now_ns() + kPatience; first->counts().refused == 0 && now_ns() < end;)
    CHECK(heard_of(*stranger, 0, "let me in", *first, 400).empty());
  CHECK(first->counts().refused != 0);
}

TEST_CASE("who listens with another key is not spoken to") {
  const int port = free_port();
  auto plans = plans_of_two(port, port);
  plans[0].keys = zmq_fabric::make_keys();
  const auto false_server = opened(plans[0]);
  const auto second = opened(plans[1]);
  CHECK(heard_of(*second, 0, "a secret", *false_server, 400).empty());
}

TEST_CASE("a peer with a key cannot say that it is another, nor send what is too large or in parts") {
  const int port = free_port();
  const auto plans = plans_of_two(port, port);
  const auto first = opened(plans[0]);
  void* const context = zmq_ctx_new();
  const auto attempt = [&](std::uint32_t as, const std::vector<std::string>& parts, int ms = 400) {
    void* const socket = zmq_socket(context, ZMQ_DEALER);
    std::string identity = "n";
    for (int shift = 0; shift < 32; shift += 8) identity += static_cast<char>(as >> shift & 0xff);
    const int linger = 0;
    zmq_setsockopt(socket, ZMQ_LINGER, &linger, sizeof linger);
    zmq_setsockopt(socket, ZMQ_ROUTING_ID, identity.data(), identity.size());
    zmq_setsockopt(socket, ZMQ_CURVE_SERVERKEY, plans[1].open_keys[0].c_str(), 40);
    zmq_setsockopt(socket, ZMQ_CURVE_PUBLICKEY, plans[1].keys.open.c_str(), 40);
    zmq_setsockopt(socket, ZMQ_CURVE_SECRETKEY, plans[1].keys.secret.c_str(), 40);
    REQUIRE(zmq_connect(socket, address_of(port).c_str()) == 0);
    for (std::size_t i = 0; i < parts.size(); ++i)
      REQUIRE(zmq_send(socket, parts[i].data(), parts[i].size(), i + 1 == parts.size() ? 0 : ZMQ_SNDMORE) >= 0);
    const std::vector<Arrival> arrivals = heard_by(*first, ms);
    zmq_close(socket);
    return arrivals;
  };
  CHECK(attempt(0, {"I am the first"}).empty());
  CHECK(attempt(7, {"I am the seventh"}).empty());
  CHECK(attempt(1, {std::string((std::size_t{1} << 26) + 1, 'x')}).empty());
  CHECK(attempt(1, {"in", "parts"}).empty());
  const std::vector<Arrival> good = attempt(1, {"as it should be"}, kPatienceMs);
  REQUIRE(good.size() == 1);
  CHECK(good[0].from == 1);
  zmq_ctx_term(context);
}

TEST_CASE("links lose and double nothing while connections stall, end and are cut") {
  testing::ImageBuilder b;
  testing::build_pairs(b, 1);
  Core core(b.image());
  REQUIRE(core.initialize());
  Placement placement{{"1", "2"}, std::vector<u32>(b.image().atoms.size, 0)};
  const Distribution distribution = distribute(core.tables(), core.priorities(), placement);
  const Codec codec(core.tables(), distribution, 1);
  const int listens = free_port(), port = free_port();
  const auto plans = plans_of_two(listens, port);
  const auto first = opened(plans[0]), second = opened(plans[1]);
  Relay relay(port, listens, 3);
  Station stations[] = {{*first, codec, 0, 2}, {*second, codec, 1, 2}};
  Fabric* const fabrics[] = {first.get(), second.get()};
  u64 said[] = {0, 0}, heard[] = {0, 0};
  Prng draws(1);
  stations[1].greet(0);
  const auto turn = [&] {
    for (u32 self = 0; self < 2; ++self) {
      std::vector<Arrival> arrivals;
      (void)fabrics[self]->wait(1, {}, arrivals);
      std::vector<ReceivedMessage> messages;
      for (const Arrival& arrival : arrivals) stations[self].take(arrival, now_ns(), messages);
      for (const ReceivedMessage& message : messages) REQUIRE(std::get<Stop>(message.message).step == ++heard[self]);
      stations[self].send(now_ns());
      stations[self].tick(now_ns());
    }
  };
  const std::int64_t end = now_ns() + 4000000000, latest = end + kPatience;
  while (now_ns() < end || ((relay.faults() <= 20 || said[0] <= 1000) && now_ns() < latest)) {
    for (u32 self = 0; self < 2; ++self) {
      for (u64 n = draws.below(20); n > 0; --n) stations[self].say(1 - self, Stop{++said[self]});
    }
    turn();
  }
  relay.is_calm = true;
  const std::int64_t give_up = now_ns() + kPatience;
  while ((heard[0] != said[1] || heard[1] != said[0]) && now_ns() < give_up) turn();
  CHECK(heard[0] == said[1]);
  CHECK(heard[1] == said[0]);
  CHECK(said[0] > 1000);
  CHECK(relay.faults() > 20);
  CHECK(stations[0].counts().refused == 0);
}
