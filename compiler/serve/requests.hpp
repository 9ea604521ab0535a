// Requests of clients for services of robot modules (compiler/docs/genom.md), numbered, in a queue a module.
//
// A mailbox is an atom with ports for events `request` and `urgent` and the text `services`; `bipc genom --served`
// writes them. A mailbox holds one request, and one that overtakes it; the others wait here, so that they can be taken
// back, and no module's requests wait for another's. What is not known, or does not have its values, is refused before
// it gets there.
#pragma once
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "bip/bip.hpp"
#include "bip/service_requests.hpp"

namespace bip::serve {

/// What becomes of a request. A request has one final reply, an accepted activity an intermediate one before it.
struct RequestReply {
  std::uint64_t request = 0;
  std::uint64_t client = 0;  // who asked
  std::string service;
  bool is_final = false;
  std::string report;
  std::string result = {};  // a JSON object of the model's C++: what else there is to tell; or empty
};

class Requests {
 public:
  /// For a module, but for the share that each client has. Of those that overtake, for a module and a client.
  static constexpr std::size_t kMostWaiting = 1000;
  static constexpr std::size_t kLeastShare = 10;
  static constexpr std::size_t kMostAlike = 20;    // that overtake: of one text and input, of one client
  static constexpr std::size_t kMostOfGone = 100;  // for a module, whose clients have left

  /// Looks for mailboxes. Linear in the atoms.
  Requests(const rt::Image& image, Execution& system);
  [[nodiscard]] bool any() const { return !mailboxes_.empty(); }
  /// Called on the engine's thread; set before it begins.
  std::function<void(const RequestReply&)> on_reply;
  /// Of the model's C++ (bip/codels.hpp): what an activity, or a service, tells with its final reply. May be null.
  /// Also of the model's C++: what is wrong with an input of a service; empty if nothing is. Any thread; may be null.
  const char* (*input_problem)(const char* service, const char* input) = nullptr;
  const char* (*result_of)(const char* whose, int is_activity) = nullptr;
  /// Also of the model's C++: what a poster holds, JSON; empty: nothing was written yet, null: there is no such poster.
  /// The engine's thread; may be null.
  const char* (*poster_value)(const char* poster) = nullptr;
  /// Also of the model's C++: how long codels took, a JSON array. Any thread; may be null.
  const char* (*codel_times)() = nullptr;

  // ---- any thread
  /// "NDD.GoTo(3)" with what its codels get. Its values are settled (request_values.hpp), so that rules judge what
  /// codels get. Returns an empty text, and its number; or why it is refused.
  [[nodiscard]] std::string ask(const std::string& asked, const std::string& asked_input, std::uint64_t client,
                                std::uint64_t& number);
  /// The client asks for no more, and hears of nothing. What of it waits goes on, as far as there is room for clients
  /// that have left; the others are lost.
  void leave(std::uint64_t client);
  /// Takes a request back, or tells its activity to stop. Its final reply tells what came of it. Returns an empty text,
  /// or why not.
  [[nodiscard]] std::string cancel(std::uint64_t number, std::uint64_t client);
  /// genom3's service of each component: "demo.abort_activity" with the number of the request whose activity is to
  /// stop. Returns as `ask` does. If that request has no activity now, `at_once` is the final reply,
  /// `no_such_activity`.
  [[nodiscard]] std::string abort_activity(const std::string& service, std::uint64_t number, std::uint64_t client,
                                           std::uint64_t& count, std::optional<RequestReply>& at_once);
  /// For codels that call services of other modules (bip::service_caller()): asks as a client does, and waits for the
  /// final reply. Not the engine's thread. end_calls(): each call, also later ones, ends with the report `LOST`.
  [[nodiscard]] RequestReply call(const std::string& text, const std::string& input);
  void end_calls();
  /// Is it the path of a mailbox's port for events?
  [[nodiscard]] bool is_mailbox_port(const std::string& path) const;
  struct Row {
    std::uint64_t request = 0;
    std::string service;
    bool is_running = false;
  };
  /// Those that have no final reply yet, by number.
  [[nodiscard]] std::vector<Row> open() const;
  [[nodiscard]] std::vector<ServiceText> services() const;

  // ---- the engine's thread
  void note_step(const Step& step);
  /// Must note_step() hear of the steps of this port? Any thread, after the constructor.
  [[nodiscard]] bool hears(const std::string& port) const;
  /// The model was set back: what waits here waits on, nothing is known of the others.
  void forget();

 private:
  struct Request {
    std::uint64_t number = 0, client = 0;
    std::string service, text, input;
    bool is_cancelled = false;
    std::string asked_as{};  // the service in replies, if it is not `service`
  };
  /// Where a request is; it moves down.
  struct Mailbox {
    std::string path;  // "ROOT.NDD_mail"
    std::string directory;
    std::vector<ServiceText> services;                    // texts of `directory`
    std::uint32_t request = 0, urgent = 0, withdraw = 0;  // ports for events
    std::deque<Request> waiting, overtaking;
    std::deque<Request> held, held_urgent;   // in the model's mailbox, at most one each
    std::deque<Request> asked;               // the module decides, at most one
    std::map<std::string, Request> running;  // by the path of its activity
    [[nodiscard]] const ServiceText* find(std::string_view service) const;
  };
  enum class MailboxSignal : std::uint8_t { Ask, Lost, Dropped, Told, Accepted };
  struct Port {
    std::size_t mailbox;
    MailboxSignal heard;
  };

  [[nodiscard]] std::string unknown(std::string_view service) const;
  [[nodiscard]] static std::string full(const Mailbox& box, const ServiceText& service, const Request& request);
  void enter(Mailbox& box, const ServiceText& service, Request request);
  void hand_over(Mailbox& box);
  void hear(Mailbox& box, MailboxSignal what, const Step& step, std::uint32_t port);
  void hear_end(const Step& step, std::uint32_t port);
  void send(const RequestReply& reply);
  void reply(const Request& request, bool is_final, const std::string& report, std::string result = {});
  [[nodiscard]] std::string result(const std::string& whose, bool is_activity) const;

  Execution& system_;
  std::vector<Mailbox> mailboxes_;
  std::unordered_map<std::string, Port> ports_;
  std::unordered_map<std::string, std::size_t> activities_;  // that run: the mailbox
  mutable std::mutex lock_;
  std::uint64_t next_ = 1;
  std::vector<RequestReply> replies_;  // of a step, sent without the lock
  // Of calls: final replies by number, null until they come.
  std::mutex calls_lock_;
  std::condition_variable answered_;
  std::map<std::uint64_t, std::optional<RequestReply>> calls_;
  bool calls_end_ = false;
};

}  // namespace bip::serve
