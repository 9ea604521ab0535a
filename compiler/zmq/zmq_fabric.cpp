// See zmq_fabric.hpp.
#include "compiler/zmq/zmq_fabric.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <map>
#include <thread>
#include <utility>
#include <vector>

#include <zmq.h>

#include "bip/assert.hpp"

namespace bip::zmq_fabric {
namespace {

constexpr int kMostBytes = 1 << 26;
constexpr int kMostStalled = 5000;  // ms that sent bytes wait for TCP's confirmation
// ms between attempts to connect, at most; the library adds up to as much again. A peer that was started later is there
// before a person notices.
constexpr int kMostReconnect = 50;
constexpr std::size_t kKeyText = 40;  // of 32 bytes
// Of what has arrived at a socket, bytes that one wait hands over: the caller looks at its clock and its other duties
// between two portions, however far it is behind those who send.
constexpr std::size_t kPortion = std::size_t{1} << 18;
constexpr const char* kDoor = "inproc://zeromq.zap.01";
constexpr const char* kFailures = "inproc://failures";
// Handshakes that end before a key is asked about: other server keys, other protocols, odd bytes.
constexpr int kFailedHandshakes = ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL;

class Socket {
 public:
  Socket(void* context, int kind) : socket_(zmq_socket(context, kind)) {}
  Socket(Socket&& other) noexcept : socket_(std::exchange(other.socket_, nullptr)) {}
  Socket& operator=(Socket&&) = delete;
  ~Socket() {
    if (socket_ != nullptr) zmq_close(socket_);
  }
  [[nodiscard]] void* get() const { return socket_; }
  [[nodiscard]] bool set(int option, int value) { return zmq_setsockopt(socket_, option, &value, sizeof value) == 0; }
  [[nodiscard]] bool set(int option, const std::string& value) {
    return zmq_setsockopt(socket_, option, value.data(), value.size()) == 0;
  }

 private:
  void* socket_;
};

struct Bytes {
  Bytes() { zmq_msg_init(&message); }
  Bytes(const Bytes&) = delete;
  Bytes& operator=(const Bytes&) = delete;
  ~Bytes() { zmq_msg_close(&message); }
  [[nodiscard]] std::string_view view() {
    return {static_cast<const char*>(zmq_msg_data(&message)), zmq_msg_size(&message)};
  }
  zmq_msg_t message;
};

// Routing identities: the peer's number, behind a byte that is not 0.
std::string identity_of(std::uint32_t peer) {
  std::string identity = "n";
  for (int shift = 0; shift < 32; shift += 8) identity += static_cast<char>(peer >> shift & 0xff);
  return identity;
}

class ZmqFabric final : public rt::Fabric {
 public:
  ZmqFabric() : context_(zmq_ctx_new()) {}
  ZmqFabric(const ZmqFabric&) = delete;
  ZmqFabric& operator=(const ZmqFabric&) = delete;
  ~ZmqFabric() override {
    listener_.reset();
    connected_.clear();
    // Ends the doorkeeper's wait.
    zmq_ctx_shutdown(context_);
    if (doorkeeper_.joinable()) doorkeeper_.join();
    zmq_ctx_term(context_);
  }

  [[nodiscard]] bool open(const rt::FabricPlan& plan) {
    BIP_ASSERT(plan.self < plan.addresses.size() && plan.addresses.size() == plan.open_keys.size(),
               "peer {} of {}, {} keys", plan.self, plan.addresses.size(), plan.open_keys.size());
    self_ = plan.self;
    for (std::uint32_t peer = 0; peer < plan.open_keys.size(); ++peer) {
      std::array<std::uint8_t, 32> key{};
      if (plan.open_keys[peer].size() != kKeyText ||
          zmq_z85_decode(key.data(), plan.open_keys[peer].c_str()) == nullptr)
        return false;
      keys_[std::string(reinterpret_cast<const char*>(key.data()), key.size())] = peer;
    }
    if (!plan.addresses[self_].empty() && !listen(plan)) return false;
    for (std::uint32_t peer = 0; peer < self_; ++peer) {
      if (!connect(plan, peer)) return false;
    }
    fill_poll_items();
    return true;
  }

  void send(std::uint32_t peer, std::string_view bytes) override {
    BIP_ASSERT(peer < self_ || (peer > self_ && listener_ != nullptr), "from {} to {}, who cannot connect", self_,
               peer);
    if (peer < self_) {
      (void)zmq_send(connected_[peer].get(), bytes.data(), bytes.size(), ZMQ_DONTWAIT);
      return;
    }
    const std::string identity = identity_of(peer);
    // Who has not connected yet cannot be reached.
    if (zmq_send(listener_->get(), identity.data(), identity.size(), ZMQ_SNDMORE | ZMQ_DONTWAIT) < 0) return;
    (void)zmq_send(listener_->get(), bytes.data(), bytes.size(), ZMQ_DONTWAIT);
  }

  bool wait(int ms, const std::vector<int>& files, std::vector<rt::Arrival>& arrivals) override {
    receive(arrivals);
    if (!arrivals.empty()) ms = 0;
    items_.resize(sockets_);
    for (const int file : files) items_.push_back({nullptr, file, ZMQ_POLLIN, 0});
    if (zmq_poll(items_.data(), static_cast<int>(items_.size()), ms) <= 0) return false;
    receive(arrivals);
    return std::any_of(items_.begin() + static_cast<std::ptrdiff_t>(sockets_), items_.end(),
                       [](const zmq_pollitem_t& item) { return item.revents != 0; });
  }

  [[nodiscard]] rt::FabricCounts counts() override { return {refused_.load(std::memory_order_relaxed)}; }

 private:
  [[nodiscard]] bool prepare(Socket& socket, const rt::FabricPlan& plan) {
    return socket.get() != nullptr && socket.set(ZMQ_LINGER, 0) && socket.set(ZMQ_SNDHWM, 0) &&
           socket.set(ZMQ_RCVHWM, 0) && socket.set(ZMQ_HEARTBEAT_IVL, 0) && socket.set(ZMQ_IPV6, 1) &&
           socket.set(ZMQ_CURVE_PUBLICKEY, plan.keys.open) && socket.set(ZMQ_CURVE_SECRETKEY, plan.keys.secret);
  }

  // To other hosts: what cannot be sent is dropped, so that nothing piles up while a host is away, and a connection
  // that only seems to be one is made anew.
  [[nodiscard]] static bool prepare_remote(Socket& socket, const std::string& address) {
    if (!address.starts_with("tcp:")) return true;
    return socket.set(ZMQ_IMMEDIATE, 1) && socket.set(ZMQ_TCP_MAXRT, kMostStalled);
  }

  [[nodiscard]] bool set_most_bytes(Socket& socket) {
    const std::int64_t most = kMostBytes;
    return zmq_setsockopt(socket.get(), ZMQ_MAXMSGSIZE, &most, sizeof most) == 0;
  }

  [[nodiscard]] bool listen(const rt::FabricPlan& plan) {
    // The door is there before anybody can knock.
    Socket door(context_, ZMQ_REP);
    if (door.get() == nullptr || !door.set(ZMQ_LINGER, 0) || zmq_bind(door.get(), kDoor) != 0) return false;
    Socket socket(context_, ZMQ_ROUTER);
    Socket failures(context_, ZMQ_PAIR);
    if (socket.get() == nullptr || failures.get() == nullptr ||
        zmq_socket_monitor(socket.get(), kFailures, kFailedHandshakes) != 0 ||
        zmq_connect(failures.get(), kFailures) != 0)
      return false;
    doorkeeper_ = std::thread([this, asked = std::move(door), failed = std::move(failures)] {
      zmq_pollitem_t items[] = {{asked.get(), 0, ZMQ_POLLIN, 0}, {failed.get(), 0, ZMQ_POLLIN, 0}};
      while (zmq_poll(items, 2, -1) >= 0 || errno == EINTR) {
        if (items[0].revents != 0 && !answer_at_door(asked.get())) return;
        if (items[1].revents != 0 && !count_failure(failed.get())) return;
      }
    });
    if (!prepare(socket, plan) || !set_most_bytes(socket) || !socket.set(ZMQ_ROUTER_HANDOVER, 1) ||
        !socket.set(ZMQ_ROUTER_MANDATORY, 1) || !socket.set(ZMQ_CURVE_SERVER, 1) ||
        !socket.set(ZMQ_ZAP_DOMAIN, std::string("bipc")) || zmq_bind(socket.get(), plan.addresses[self_].c_str()) != 0)
      return false;
    listener_ = std::make_unique<Socket>(std::move(socket));
    return true;
  }

  [[nodiscard]] bool connect(const rt::FabricPlan& plan, std::uint32_t peer) {
    Socket socket(context_, ZMQ_DEALER);
    if (!prepare(socket, plan) || !prepare_remote(socket, plan.addresses[peer]) || !set_most_bytes(socket) ||
        !socket.set(ZMQ_ROUTING_ID, identity_of(self_)) || !socket.set(ZMQ_CURVE_SERVERKEY, plan.open_keys[peer]) ||
        !socket.set(ZMQ_RECONNECT_IVL, 20) || !socket.set(ZMQ_RECONNECT_IVL_MAX, kMostReconnect) ||
        zmq_connect(socket.get(), plan.addresses[peer].c_str()) != 0)
      return false;
    BIP_ASSERT(connected_.size() == peer, "peer {} has row {}", peer, connected_.size());
    connected_.push_back(std::move(socket));
    return true;
  }

  void fill_poll_items() {
    if (listener_) items_.push_back({listener_->get(), 0, ZMQ_POLLIN, 0});
    for (const Socket& socket : connected_) items_.push_back({socket.get(), 0, ZMQ_POLLIN, 0});
    sockets_ = items_.size();
  }

  // Takes a message whole; returns the number of its parts, of which `bytes` is the last. 0: there is none.
  static int take_parts(void* socket, Bytes& bytes) {
    int parts = 0;
    do {
      if (zmq_msg_recv(&bytes.message, socket, ZMQ_DONTWAIT) < 0) return 0;
      ++parts;
    } while (zmq_msg_more(&bytes.message) != 0);
    return parts;
  }

  // Takes a portion of what has arrived at each socket. Frames of this protocol have one part; others are refused.
  void receive(std::vector<rt::Arrival>& arrivals) {
    for (std::uint32_t peer = 0; peer < connected_.size(); ++peer) {
      Bytes bytes;
      for (std::size_t taken = 0; taken < kPortion; taken += bytes.view().size()) {
        const int parts = take_parts(connected_[peer].get(), bytes);
        if (parts == 0) break;
        if (parts == 1) arrivals.push_back({peer, std::string(bytes.view())});
        else refused_.fetch_add(1, std::memory_order_relaxed);
      }
    }
    if (!listener_) return;
    std::size_t taken = 0;
    for (Bytes identity; taken < kPortion && zmq_msg_recv(&identity.message, listener_->get(), ZMQ_DONTWAIT) >= 0;) {
      Bytes bytes;
      const bool is_whole = zmq_msg_more(&identity.message) != 0 && take_parts(listener_->get(), bytes) == 1;
      taken += bytes.view().size();
      const char* user = is_whole ? zmq_msg_gets(&bytes.message, "User-Id") : nullptr;
      const auto peer = user == nullptr ? 0 : static_cast<std::uint32_t>(std::strtoul(user, nullptr, 10));
      // Who says that he is another is not heard, and would get what is the other's.
      if (user != nullptr && identity.view() == identity_of(peer))
        arrivals.push_back({peer, std::string(bytes.view())});
      else refused_.fetch_add(1, std::memory_order_relaxed);
    }
  }

  // All parts of a message. False: the sockets are closed.
  static bool receive_parts(void* socket, std::vector<std::string>& parts) {
    for (bool more = true; more;) {
      Bytes part;
      if (zmq_msg_recv(&part.message, socket, 0) < 0) {
        if (errno == EINTR) continue;
        return false;
      }
      parts.emplace_back(part.view());
      more = zmq_msg_more(&part.message) != 0;
    }
    return true;
  }

  // Answers ZeroMQ's question whether a key may connect (ZAP, RFC 27), on a thread that sleeps otherwise.
  // Requests: version, number, domain, address, identity, mechanism, key. Answers: version, number, status, text,
  // user, metadata.
  bool answer_at_door(void* door) {
    std::vector<std::string> request;
    if (!receive_parts(door, request)) return false;
    if (request.size() < 2) return true;
    const auto known = request.size() == 7 && request[5] == "CURVE" ? keys_.find(request[6]) : keys_.end();
    if (known == keys_.end()) refused_.fetch_add(1, std::memory_order_relaxed);
    const std::string user = known == keys_.end() ? std::string() : std::to_string(known->second);
    const std::string answer[] = {"1.0", request[1], known == keys_.end() ? "400" : "200", "", user, ""};
    for (std::size_t i = 0; i < std::size(answer); ++i)
      (void)zmq_send(door, answer[i].data(), answer[i].size(), i + 1 == std::size(answer) ? 0 : ZMQ_SNDMORE);
    return true;
  }

  bool count_failure(void* failures) {
    std::vector<std::string> event;
    if (!receive_parts(failures, event)) return false;
    refused_.fetch_add(1, std::memory_order_relaxed);
    return true;
  }

  void* context_;
  std::uint32_t self_ = 0;
  std::map<std::string, std::uint32_t> keys_;  // by the key's 32 bytes: the peer
  std::thread doorkeeper_;
  std::atomic<std::uint64_t> refused_{0};
  std::unique_ptr<Socket> listener_;
  std::vector<Socket> connected_;  // by peer
  std::vector<zmq_pollitem_t> items_;
  std::size_t sockets_ = 0;
};

}  // namespace

rt::FabricKeys make_keys() {
  std::array<char, kKeyText + 1> open{}, secret{};
  if (zmq_curve_keypair(open.data(), secret.data()) != 0) return {};
  return {open.data(), secret.data()};
}

Result<std::unique_ptr<rt::Fabric>> open(const rt::FabricPlan& plan) {
  auto fabric = std::make_unique<ZmqFabric>();
  errno = 0;
  if (fabric->open(plan)) return std::unique_ptr<rt::Fabric>(std::move(fabric));
  return Failure{errno == 0 ? "a key is no key" : zmq_strerror(errno)};
}

std::string version() {
  int major = 0, minor = 0, patch = 0;
  zmq_version(&major, &minor, &patch);
  return std::to_string(major) + '.' + std::to_string(minor) + '.' + std::to_string(patch);
}

}  // namespace bip::zmq_fabric
