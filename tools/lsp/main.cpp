// bipc-lsp: the language server on standard input and output. Nothing else is ever written to standard output.
//
// Ends after `exit`, or with 1 when the input ends without it.
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <string_view>

#include "bip/process.hpp"
#include "compiler/base/framed_output.hpp"
#include "tools/lsp/language_server.hpp"

namespace {

constexpr std::size_t kMostAtOnce = 1u << 20;

// Between two keys of a person who goes on typing.
constexpr int kPauseMs = 300;

bool has_input(int ms) {
  pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  return ::poll(&input, 1, ms) > 0 && (input.revents & POLLIN) != 0;
}

int serve() {
  using Queue = bip::lsp::Server::Queue;
  bip::FramedOutput output(STDOUT_FILENO);
  bip::lsp::Server server([&output](std::string_view message) { output.write(message); });
  bip::Framing framing;
  std::string chunk;
  int read_error = 0;
  while (output.error() == 0) {
    while (auto frame = framing.next()) {
      server.handle(*frame, framing.has_more() || has_input(0) ? Queue::HasMore : Queue::Empty);
      if (server.is_finished() && output.error() == 0) return server.exit_code();
      if (output.error() != 0) break;
    }
    if (server.is_behind() && !has_input(kPauseMs)) server.catch_up();
    if (server.is_unfinished() && !has_input(0)) server.finish();
    chunk.resize(std::clamp<std::size_t>(framing.missing(), 4096, kMostAtOnce));
    const ssize_t got = ::read(STDIN_FILENO, chunk.data(), chunk.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) read_error = errno;
    if (got <= 0) break;
    framing.feed(std::string_view(chunk).substr(0, static_cast<std::size_t>(got)));
  }
  if (output.error() != 0) return bip::report_lost_output(output.error());
  if (read_error != 0) {
    std::fprintf(stderr, "error: cannot read standard input: %s\n", std::strerror(read_error));
    return bip::kOutputLost;
  }
  std::fputs("error: standard input has ended before the notification `exit`\n", stderr);
  return 1;
}

}  // namespace

static int run_server(int argc, char** argv) {
  // Editors pass `--stdio`; there is no other way to talk, so it says nothing.
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--stdio") == 0) continue;
    const bool wants_help = std::strcmp(argv[i], "--help") == 0;
    std::fputs(
        "Usage: bipc-lsp [--stdio]\n\nThe language server of BIP, to be started by an editor; it talks on standard "
        "input "
        "and output.\n\nOptions:\n  --stdio  as editors write it; there is no other way to talk\n",
        wants_help ? stdout : stderr);
    return wants_help ? 0 : 2;
  }
  return serve();
}

int main(int argc, char** argv) { return bip::run_process(run_server, argc, argv); }
