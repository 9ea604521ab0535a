// Decodes one request of a client (compiler/docs/serve.md), executes it and encodes its answer. Knows nothing of
// sockets.
//
// Every malformed request is refused with a reason: the reader limits the size of lines, values are checked against the
// model, unknown words are named in the answer. Nothing throws.
#pragma once
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "compiler/serve/controller.hpp"

namespace bip::serve {

/// The steps of which a client receives notes, or after which the model pauses for it.
struct Subscription {
  bool is_on = false;
  std::set<std::string> interactions;
  std::vector<std::string> ports;  // ends of paths, "panel.turn"
  bool hears_requests = false;     // what becomes of requests of any client
  /// Of these interactions, or with one of these ports; without both, all.
  [[nodiscard]] bool wants(const Step& step) const;
};

/// What a client may do: an observer looks, a requester also posts events and asks for services, an operator also
/// steers the run and ends it.
enum class Role : std::uint8_t { Observer, Requester, Operator };
[[nodiscard]] const char* role_name(Role role);

struct Reply {
  std::uint64_t client = 0;
  Role role = Role::Operator;
  /// The client asks for less than it may do.
  std::function<void(Role role)> take_role;
  /// With its newline; from any thread, once or later.
  std::function<void(std::string line)> send;
  std::function<void(const Subscription&)> subscribe;
  std::function<void(const Subscription&)> break_at;
  std::function<void()> shut_down;
};

/// Object: JSON, with numbers of any size, or too deep to be looked at.
enum class LineKind : std::uint8_t { Object, NoObject };
[[nodiscard]] LineKind kind_of_line(const std::string& line);

/// Does the line post an event, or ask for a service? Then its sender is part of the decisional level.
[[nodiscard]] bool is_asking(const std::string& line);

/// Returns the token of a line that is a sound `hello`; empty: it is none, or has none.
[[nodiscard]] std::string token_of_hello(const std::string& line);

/// Does what the line says.
void handle_line(Controller& controller, const std::string& line, Reply reply);

/// `{"note":"step",…}`, with "break" the note of a pause, and `{"note":"end",…}` with a newline.
[[nodiscard]] std::string step_line(const Step& step, std::int64_t now, const char* note = "step");
/// `{"note":"request",…}`
[[nodiscard]] std::string request_line(const RequestReply& reply, std::int64_t now);
/// `{"note":"stalled",…}`, `"runs again"`, `"late"`
[[nodiscard]] std::string alarm_line(const Alarm& alarm);
[[nodiscard]] std::string end_line(Outcome outcome, const std::string& text);
[[nodiscard]] std::string error_line(const std::string& what);

}  // namespace bip::serve
