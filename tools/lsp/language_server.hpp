// The server: takes messages, sends messages, keeps the protocol's order of initialize, work, shutdown, exit.
//
// Whatever a message holds, the answer is a result or a JSON-RPC error; a notification that makes no sense is reported
// to the client's log and has no effect.
#pragma once
#include <functional>
#include <string>
#include <string_view>

#include "tools/lsp/framing.hpp"
#include "tools/lsp/workspace.hpp"

namespace bip::lsp {

class Server {
 public:
  /// `send` gets one message's JSON at a time, without header.
  explicit Server(std::function<void(std::string_view)> send) : send_(std::move(send)) {}

  void handle(std::string_view body);
  void handle(const Framing::Frame& frame);
  [[nodiscard]] bool is_finished() const { return state_ == State::Finished; }
  /// 0 after an orderly shutdown, 1 if `exit` came without.
  [[nodiscard]] int exit_code() const { return exit_code_; }

 private:
  enum class State { Fresh, Running, ShutDown, Finished };

  void dispatch(const Json& message);
  void request(const Json& id, const std::string& method, const Json& params);
  void notification(const std::string& method, const Json& params);
  [[nodiscard]] Reply answer(const std::string& method, const Json& params);
  [[nodiscard]] Reply initialize(const Json& params);
  [[nodiscard]] Reply at_position(const std::string& method, const Json& params);

  void did_open(const Json& params);
  void did_change(const Json& params);
  void did_close(const Json& params);
  void did_save(const Json& params);

  void check(const std::string& path);
  void log(const std::string& text);
  void fail(const Json& id, ErrorCode code, const std::string& message);
  void notify(const char* method, Json params);
  void send(const Json& message);

  std::function<void(std::string_view)> send_;
  Workspace workspace_;
  State state_ = State::Fresh;
  int exit_code_ = 0;
};

}  // namespace bip::lsp
