// What a server of pages (page_server.hpp) asks of the session that it shows: one of this process (live_session.hpp),
// or a model that another process runs (attached_session.hpp). Knows no sockets of pages. One thread calls all.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace bip::live {

class PageSession {
 public:
  PageSession() = default;
  PageSession(const PageSession&) = delete;
  PageSession& operator=(const PageSession&) = delete;
  virtual ~PageSession() = default;

  /// Called with a message for one page or for all; set before the first request.
  std::function<void(std::uint64_t page, const std::string& message)> send;
  std::function<void(const std::string& message)> send_to_all;

  /// Tells a page that has come the run so far.
  virtual void greet(std::uint64_t page) = 0;
  /// Answers a request. False: it is none; nothing was done.
  [[nodiscard]] virtual bool handle(std::uint64_t page, std::string_view message) = 0;
  /// A page has gone: what it had begun ends.
  virtual void leave(std::uint64_t page) = 0;

  /// Whether a walk or a run goes on: then go_on() is called again and again.
  [[nodiscard]] virtual bool is_running() const { return false; }
  virtual void go_on() {}
  /// A signal ended the process while the model moved.
  [[nodiscard]] virtual bool is_interrupted() const { return false; }

  /// A descriptor to wait at: hear() is called when something can be read from it. -1: there is none.
  [[nodiscard]] virtual int descriptor() const { return -1; }
  /// False: the other end is gone, and with it the session.
  [[nodiscard]] virtual bool hear() { return true; }
  /// Called some times in a second if there is a descriptor. False: as hear().
  [[nodiscard]] virtual bool tick() { return true; }
};

}  // namespace bip::live
