// The process that forks the processes of robot modules, and again when one of them has died (codel_processes.hpp). It
// never runs a codel. Header only; Linux.
#pragma once
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <exception>

#include "bip/codel_calls.hpp"
#include "bip/codel_channels.hpp"
#include "bip/codel_module.hpp"

namespace bip::processes {

/// From the controller, if the module still has this generation.
struct NurseryCommand {
  char what = 0;  // s: start, k: kill
  std::int32_t module = 0;
  std::uint32_t generation = 0;
};

class Nursery {
 public:
  Nursery(const Description& description, Channels& shared) : description_(description), shared_(shared) {}

  // Ends with the controller, and with it end the modules' processes.
  [[noreturn]] void run(int socket) {
    constexpr int kChildren = 4;
    if (socket != kSocket) (void)::dup2(socket, kSocket);
    (void)::close_range(4, ~0U, 0);
    if (const int nothing = ::open("/dev/null", O_RDONLY); nothing > 0) {
      (void)::dup2(nothing, STDIN_FILENO);
      ::close(nothing);
    }
    (void)::prctl(PR_SET_NAME, "bip-modules");
    std::set_terminate([] { std::abort(); });
    for (int number = 1; number < 32; ++number) {
      if (number != SIGPIPE && number != SIGKILL && number != SIGSTOP) (void)::signal(number, SIG_DFL);
    }
    // Of a terminal: for the controller.
    for (const int number : {SIGINT, SIGHUP, SIGQUIT}) (void)::signal(number, SIG_IGN);
    sigset_t children;
    sigemptyset(&children);
    sigaddset(&children, SIGCHLD);
    (void)::sigprocmask(SIG_SETMASK, &children, nullptr);
    if (::signalfd(-1, &children, 0) != kChildren) ::_exit(1);
    pollfd ends[] = {{kSocket, POLLIN, 0}, {kChildren, POLLIN, 0}};
    while (true) {
      if (::poll(ends, 2, -1) < 0 && errno != EINTR) ::_exit(1);
      if (ends[1].revents != 0) {
        signalfd_siginfo ignored;
        (void)!::read(kChildren, &ignored, sizeof ignored);
        int status = 0;
        for (pid_t pid = 0; (pid = ::waitpid(-1, &status, WNOHANG)) > 0;) bury(pid, status);
      }
      if (ends[0].revents == 0) continue;
      NurseryCommand message;
      if (::recv(kSocket, &message, sizeof message, 0) != sizeof message) end_modules();
      ModuleState& s = shared_.state(static_cast<std::size_t>(message.module));
      if (s.generation != message.generation) continue;
      if (message.what == 'k' && s.pid > 0) (void)::kill(s.pid, SIGKILL);
      if (message.what == 's' && s.pid == 0) fork_module(static_cast<std::size_t>(message.module));
    }
  }

 private:
  static constexpr int kSocket = 3;

  // The controller is gone, or does not need them any more.
  [[noreturn]] void end_modules() {
    for (std::size_t m = 0; m < description_.modules.size(); ++m) {
      if (shared_.state(m).pid > 0) (void)::kill(shared_.state(m).pid, SIGKILL);
    }
    while (::waitpid(-1, nullptr, 0) > 0) {
    }
    ::_exit(0);
  }
  void bury(pid_t pid, int status) {
    for (std::size_t m = 0; m < description_.modules.size(); ++m) {
      if (shared_.state(m).pid != pid) continue;
      const bool has_served = shared_.state(m).served.exchange(0) != 0;
      shared_.note_end(m, status);
      const char byte = 0;
      (void)::send(kSocket, &byte, sizeof byte, MSG_NOSIGNAL | MSG_DONTWAIT);
      // One that dies before its first answer waits until it is needed.
      if (has_served) fork_module(m);
    }
  }
  void fork_module(std::size_t module) {
    const pid_t nursery = ::getpid(), child = ::fork();
    if (child == 0) ModuleProcess(description_, shared_, module).run(nursery);
    // Without a process the callers would wait for ever.
    if (child < 0) shared_.note_end(module, SIGKILL);
    else shared_.state(module).pid = child;
  }

  const Description& description_;
  Channels& shared_;
};

}  // namespace bip::processes
