// The server: takes messages, sends messages, keeps the protocol's order of initialize, work, shutdown, exit.
//
// Whatever a message holds, the answer is a result or a JSON-RPC error; a notification that makes no sense is reported
// to the client's log and has no effect.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/base/framing.hpp"
#include "tools/lsp/workspace.hpp"

namespace bip::lsp {

class Server {
 public:
  /// `send` gets one message's JSON at a time, without header.
  explicit Server(std::function<void(std::string_view)> send) : send_(std::move(send)) {}

  /// Whether more messages are there already. Then the documents are checked after the last of several changes, and a
  /// client that types faster than a check lasts is not answered ever later.
  enum class Queue : std::uint8_t { Empty, HasMore };
  void handle(std::string_view body, Queue queue = Queue::Empty);
  void handle(const Framing::Frame& frame, Queue queue = Queue::Empty);
  /// Whether a change of a large document is not checked yet, as more may come: it is at once before requests
  /// that need a check; completion takes the names of the last one, questions about names read those of the new text
  /// alone. Else catch_up() does it after a pause.
  [[nodiscard]] bool is_behind() const { return !changed_.empty(); }
  void catch_up();
  /// Whether answers left work that they did not need: names of a large document that was checked (they are read before
  /// the first answer from names, too), and memory to free. For finish(), when no message waits.
  [[nodiscard]] bool is_unfinished() const { return changed_.empty() && workspace_.is_unfinished(); }
  void finish() { workspace_.finish(); }
  [[nodiscard]] bool is_finished() const { return state_ == State::Finished; }
  /// 0 after an orderly shutdown, 1 if `exit` came without.
  [[nodiscard]] int exit_code() const { return exit_code_; }

 private:
  enum class State { Fresh, Running, ShutDown, Finished };

  void dispatch(const Json& message);
  void request(const Json& id, const std::string& method, const Json& params);
  void add_root(const std::string& uri);
  void notification(const std::string& method, const Json& params);
  [[nodiscard]] Reply answer(const std::string& method, const Json& params);
  [[nodiscard]] Reply initialize(const Json& params);
  [[nodiscard]] Reply selection_ranges(const Document& d, const Json& params);
  [[nodiscard]] Reply at_position(const std::string& method, const Json& params);

  void did_open(const Json& params);
  void did_change(const Json& params);
  void did_close(const Json& params);
  void did_save(const Json& params);

  void check(const std::string& path);
  void check_later(const std::string& path);
  void check_changed();
  [[nodiscard]] bool can_wait();
  /// What an answer comes from: a check of what changed, or names alone, of its document or of all.
  enum class Needs : std::uint8_t { Check, OwnNames, AllNames };
  [[nodiscard]] static Needs needs_of(std::string_view method);
  /// The names that a request needs, without a check. False if only the check gives them.
  [[nodiscard]] bool read_names(Needs needs, const Json& message);
  void log(const std::string& text);
  void fail(const Json& id, ErrorCode code, const std::string& message);
  void notify(const char* method, Json params);
  void send(const Json& message);

  std::function<void(std::string_view)> send_;
  Workspace workspace_;
  std::vector<std::string> changed_;  // paths that are to be checked, in the order of their first change
  State state_ = State::Fresh;
  int exit_code_ = 0;
};

}  // namespace bip::lsp
