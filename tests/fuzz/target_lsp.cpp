// The language server with any bytes as its input, in this process. Input that begins as a header does goes through the
// framing, in pieces of changing length; any other input is cut at line ends, and each line is a message's body, so
// that an edit does not have to mend a length. The server starts initialised, for most of what it can do comes after
// that.
//
// What it must keep: everything sent is JSON; a request has one answer, which is no internal error; and it goes on: the
// last question has an answer unless the input ended the session.
#include <algorithm>
#include <map>
#include <string>

#include "tests/fuzz/targets.hpp"
#include "tools/lsp/language_server.hpp"

namespace bip::fuzz {
namespace {

using lsp::Json;

constexpr std::string_view kInitialize = R"({"jsonrpc":"2.0","id":"fuzz-first","method":"initialize","params":{}})";
constexpr std::string_view kInitialized = R"({"jsonrpc":"2.0","method":"initialized","params":{}})";
constexpr std::string_view kLast = R"({"jsonrpc":"2.0","id":"fuzz-last","method":"textDocument/hover","params":{}})";

/// The client's end: what came, judged as it comes.
class Client {
 public:
  void take(std::string_view text) {
    const Json message = Json::parse(text, nullptr, /*allow_exceptions=*/false);
    if (message.is_discarded() || !message.is_object()) return note("the server sent no JSON");
    if (message.contains("method")) return;
    if (!message.contains("id") || message.contains("result") == message.contains("error"))
      return note("an answer that is none: " + std::string(text));
    ++answers_[message["id"].dump(-1, ' ', false, Json::error_handler_t::replace)];
    const auto error = message.find("error");
    if (error == message.end()) {
      ++results_;
      return;
    }
    if (error->value("code", 0) == static_cast<int>(lsp::ErrorCode::InternalError))
      note("internal error: " + error->value("message", std::string()));
  }
  void note(std::string problem) {
    if (problem_.empty()) problem_ = std::move(problem);
  }
  [[nodiscard]] std::size_t answers(const char* id) const {
    const auto found = answers_.find(id);
    return found == answers_.end() ? 0 : found->second;
  }
  [[nodiscard]] const std::string& problem() const { return problem_; }
  /// Another one than that of `initialize`.
  [[nodiscard]] bool has_result() const { return results_ > 1; }

 private:
  std::size_t results_ = 0;
  std::map<std::string, std::size_t> answers_;
  std::string problem_;
};

void feed_stream(lsp::Server& server, std::string_view input) {
  Framing framing;
  for (std::size_t piece = 1; !input.empty() && !server.is_finished(); piece = piece * 3 + 1) {
    const std::string_view now = input.substr(0, std::min(piece, input.size()));
    input.remove_prefix(now.size());
    framing.feed(now);
    while (const auto frame = framing.next()) server.handle(*frame);
  }
}

void feed_lines(lsp::Server& server, std::string_view input) {
  while (!input.empty()) {
    const std::size_t end = std::min(input.find('\n'), input.size());
    if (end > 0) server.handle(input.substr(0, end));
    input.remove_prefix(std::min(end + 1, input.size()));
  }
}

}  // namespace

Verdict try_lsp(std::string_view input) {
  Client client;
  lsp::Server server([&client](std::string_view text) { client.take(text); });
  server.handle(kInitialize);
  server.handle(kInitialized);
  if (input.starts_with("Content-Length:")) {
    feed_stream(server, input);
  } else {
    feed_lines(server, input);
  }
  const bool is_open = !server.is_finished();
  server.handle(kLast);
  if (is_open && client.answers("\"fuzz-last\"") == 0) client.note("the last question has no answer");
  return {client.problem(), client.has_result()};
}

}  // namespace bip::fuzz
