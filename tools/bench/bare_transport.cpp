// What a message to and fro costs without bipc: sockets of TCP, or ZeroMQ as runs on several nodes use it.
//
//   bare_transport sockets|zmq LISTEN_ADDRESS:PORT CONNECT_ADDRESS:PORT COUNT
//
// IPv4. One process listens and answers each message by one of the same size; the other connects (to the same address,
// or to a relay before it), sends, and waits for the answer. Each sleeps while it waits. Prints milliseconds of a
// message and its answer: the mean, and the median. ZeroMQ: the sockets, keys (CURVE) and calls of
// compiler/zmq/zmq_fabric.cpp.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#include <zmq.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

namespace {

constexpr std::size_t kSize = 48;  // bytes; a frame with one step of two components
using Message = std::array<char, kSize>;

[[noreturn]] void fail(const char* what) {
  std::perror(what);
  std::exit(1);
}

std::int64_t now_ns() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return std::int64_t{time.tv_sec} * 1000000000 + time.tv_nsec;
}

class End {
 public:
  virtual ~End() = default;
  virtual void send(const Message& message) = 0;
  virtual void receive(Message& message) = 0;
};

// ---- sockets

sockaddr_in address_of(const std::string& text) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos || inet_pton(AF_INET, text.substr(0, colon).c_str(), &address.sin_addr) != 1) {
    std::fprintf(stderr, "bare_transport: `%s` is no ADDRESS:PORT\n", text.c_str());
    std::exit(2);
  }
  address.sin_port = htons(static_cast<std::uint16_t>(std::atoi(text.c_str() + colon + 1)));
  return address;
}

class SocketEnd final : public End {
 public:
  explicit SocketEnd(int file) : file_(file) {
    const int on = 1;
    setsockopt(file_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  }
  ~SocketEnd() override { close(file_); }
  SocketEnd(const SocketEnd&) = delete;
  SocketEnd& operator=(const SocketEnd&) = delete;

  void send(const Message& message) override {
    if (::send(file_, message.data(), message.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(message.size()))
      fail("send");
  }
  void receive(Message& message) override {
    if (recv(file_, message.data(), message.size(), MSG_WAITALL) != static_cast<ssize_t>(message.size()))
      fail("receive");
  }

 private:
  int file_;
};

std::unique_ptr<End> accept_socket(int listener) {
  const int file = accept(listener, nullptr, nullptr);
  if (file < 0) fail("accept");
  return std::make_unique<SocketEnd>(file);
}

int listen_at(const std::string& text) {
  const sockaddr_in address = address_of(text);
  const int on = 1, listener = socket(AF_INET, SOCK_STREAM, 0);
  setsockopt(listener, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 || listen(listener, 1) != 0)
    fail("listen");
  return listener;
}

std::unique_ptr<End> connect_socket(const std::string& text) {
  const sockaddr_in address = address_of(text);
  const int file = socket(AF_INET, SOCK_STREAM, 0);
  if (connect(file, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) fail("connect");
  return std::make_unique<SocketEnd>(file);
}

// ---- ZeroMQ

struct Keys {
  std::array<char, 41> open{}, secret{};
};

class ZmqEnd final : public End {
 public:
  ZmqEnd(int kind, const std::string& address, const Keys& own, const Keys& server)
      : context_(zmq_ctx_new()), socket_(zmq_socket(context_, kind)), is_server_(kind == ZMQ_ROUTER) {
    set(ZMQ_LINGER, is_server_ ? 0 : 1000);
    for (const int option : {ZMQ_SNDHWM, ZMQ_RCVHWM, ZMQ_HEARTBEAT_IVL}) set(option, 0);
    zmq_setsockopt(socket_, ZMQ_CURVE_PUBLICKEY, own.open.data(), 40);
    zmq_setsockopt(socket_, ZMQ_CURVE_SECRETKEY, own.secret.data(), 40);
    const std::string url = "tcp://" + address;
    if (is_server_) set(ZMQ_CURVE_SERVER, 1);
    else zmq_setsockopt(socket_, ZMQ_CURVE_SERVERKEY, server.open.data(), 40);
    if ((is_server_ ? zmq_bind(socket_, url.c_str()) : zmq_connect(socket_, url.c_str())) != 0) fail("zmq");
  }
  ~ZmqEnd() override {
    zmq_close(socket_);
    zmq_ctx_term(context_);
  }
  ZmqEnd(const ZmqEnd&) = delete;
  ZmqEnd& operator=(const ZmqEnd&) = delete;

  void send(const Message& message) override {
    if (is_server_ && zmq_send(socket_, peer_.data(), peer_.size(), ZMQ_SNDMORE | ZMQ_DONTWAIT) < 0) fail("zmq send");
    if (zmq_send(socket_, message.data(), message.size(), ZMQ_DONTWAIT) < 0) fail("zmq send");
  }
  void receive(Message& message) override {
    zmq_pollitem_t item{socket_, 0, ZMQ_POLLIN, 0};
    if (zmq_poll(&item, 1, -1) < 0) fail("zmq poll");
    if (is_server_) {
      std::array<char, 256> name;
      const int size = zmq_recv(socket_, name.data(), name.size(), 0);
      if (size < 0) fail("zmq receive");
      peer_.assign(name.data(), static_cast<std::size_t>(size));
    }
    if (zmq_recv(socket_, message.data(), message.size(), 0) != static_cast<int>(message.size())) fail("zmq receive");
  }

 private:
  void set(int option, int value) { zmq_setsockopt(socket_, option, &value, sizeof value); }

  void* context_;
  void* socket_;
  bool is_server_;
  std::string peer_;
};

// ---- to and fro

void answer(End& end, int count) {
  Message message{};
  for (int k = 0; k < count; ++k) {
    end.receive(message);
    end.send(message);
  }
}

void measure(End& end, int count, int unmeasured) {
  Message message{};
  std::vector<double> taken;
  for (int k = 0; k < count + unmeasured; ++k) {
    const std::int64_t before = now_ns();
    end.send(message);
    end.receive(message);
    if (k >= unmeasured) taken.push_back(static_cast<double>(now_ns() - before) / 1e6);
  }
  double sum = 0;
  for (const double each : taken) sum += each;
  std::sort(taken.begin(), taken.end());
  std::printf("%.4f %.4f\n", sum / count, taken[taken.size() / 2]);
}

}  // namespace

int main(int argc, char** argv) {
  const int count = argc == 5 ? std::atoi(argv[4]) : 0;
  const std::string kind = argc == 5 ? argv[1] : "";
  if (count < 1 || (kind != "sockets" && kind != "zmq")) {
    std::fputs("bare_transport sockets|zmq LISTEN_ADDRESS:PORT CONNECT_ADDRESS:PORT COUNT\n", stderr);
    return 2;
  }
  constexpr int kUnmeasured = 5;
  const int listener = kind == "sockets" ? listen_at(argv[2]) : -1;
  Keys server, client;
  if (kind == "zmq" && (zmq_curve_keypair(server.open.data(), server.secret.data()) != 0 ||
                        zmq_curve_keypair(client.open.data(), client.secret.data()) != 0))
    fail("keys");
  const pid_t other = fork();
  if (other < 0) fail("fork");
  if (other == 0) {
    // The other side ends this process when the last answer has come.
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (listener >= 0) {
      const std::unique_ptr<End> end = accept_socket(listener);
      answer(*end, count + kUnmeasured);
      pause();
    } else {
      ZmqEnd end(ZMQ_ROUTER, argv[2], server, server);
      answer(end, count + kUnmeasured);
      pause();
    }
    return 0;
  }
  if (listener >= 0) {
    measure(*connect_socket(argv[3]), count, kUnmeasured);
  } else {
    ZmqEnd end(ZMQ_DEALER, argv[3], client, server);
    measure(end, count, kUnmeasured);
  }
  kill(other, SIGKILL);
  waitpid(other, nullptr, 0);
}
