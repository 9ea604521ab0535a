// The process of a robot module: runs the codels that the controller calls (codel_processes.hpp). Header only; Linux.
#pragma once
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "bip/codel_calls.hpp"
#include "bip/codel_channels.hpp"
#include "bip/codels.hpp"

namespace bip::processes {

class ModuleProcess {
 public:
  /// In the process, which never leaves run().
  ModuleProcess(const Description& description, Channels& shared, std::size_t module)
      : description_(description),
        shared_(shared),
        module_(module),
        generation_(shared.state(module).generation),
        told_(description.posters.size()) {}

  [[noreturn]] void run(pid_t nursery) {
    (void)::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != nursery) ::_exit(0);
    (void)::close_range(3, ~0U, 0);
    sigset_t none;
    sigemptyset(&none);
    (void)::sigprocmask(SIG_SETMASK, &none, nullptr);
    (void)::prctl(PR_SET_NAME, description_.modules[module_].name);
    // Handlers and static objects are the controller's.
    (void)::on_exit(
        [](int status, void*) {
          note_culprit();
          (void)std::fflush(stdout);
          ::_exit(status);
        },
        nullptr);
    struct sigaction action {};
    action.sa_handler = [](int number) {
      note_culprit();
      (void)::raise(number);
    };
    action.sa_flags = static_cast<int>(SA_RESETHAND | SA_NODEFER | SA_ONSTACK);
    for (const int number : {SIGSEGV, SIGFPE, SIGBUS, SIGABRT, SIGILL, SIGTRAP, SIGSYS})
      (void)::sigaction(number, &action, nullptr);
    shared_.while_waiting = nullptr;
    own_process = this;
    service_caller() = &ask_controller;
    if (generation_ > 1) {
      for (const StartRow& row : description_.starts) {
        if (description_.owner_rows[index(row.owner)].module != static_cast<int>(module_)) continue;
        Call call{.owner = row.owner};
        execute(row.function, call);
      }
    }
    std::thread([this] {
      for (std::uint32_t known = 1;;) {
        const std::uint32_t wanted = state().threads;
        for (; known < wanted; ++known) std::thread([this, known] { serve(known); }).detach();
        (void)futex(state().threads, FUTEX_WAIT, wanted, nullptr);
      }
    }).detach();
    limit_memory();
    serve(0);
  }

 private:
  static std::size_t index(int number) { return static_cast<std::size_t>(number); }
  [[nodiscard]] ModuleState& state() const { return shared_.state(module_); }

  // A codel's request to the controller: over the channel of its call, whose other end waits for the answer.
  static const char* ask_controller(const char* service, const char* input) {
    thread_local std::string answer;
    answer = "{}";
    if (own_process == nullptr || own_channel == 0) return answer.c_str();
    Channels& shared = own_process->shared_;
    Channel& c = shared.channel(own_process->module_, own_channel - 1);
    const std::uint32_t theirs = 2 * own_process->generation_, mine = theirs + 1;
    std::string question;
    append_text(question, service);
    append_text(question, input);
    c.function = kAsksForService;
    answer.clear();
    if (shared.send(c, mine, theirs, question, {}) != Wait::MyTurn ||
        shared.receive(c, mine, theirs, answer, {}) != Wait::MyTurn)
      ::_exit(0);
    return answer.c_str();
  }

  void limit_memory() const {
    if (description_.memory_mb <= 0) return;
    unsigned long pages[6] = {};
    if (std::FILE* const file = std::fopen("/proc/self/statm", "r"); file != nullptr) {
      for (unsigned long& number : pages) {
        if (std::fscanf(file, "%lu", &number) != 1) break;
      }
      (void)std::fclose(file);
    }
    const rlim_t limit = pages[5] * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE)) +
                         static_cast<rlim_t>(description_.memory_mb) * 1024 * 1024;
    const rlimit bound{limit, limit};
    (void)::setrlimit(RLIMIT_DATA, &bound);
  }

  void execute(int function, Call& call) const {
    const FunctionRow& row = description_.functions[index(function)];
    try {
      row.run(call);
    } catch (const std::exception& exception) {
      std::fprintf(stderr, "warning[R0048]: `%s` threw an exception: %s\n", row.name, exception.what());
    } catch (...) {
      std::fprintf(stderr, "warning[R0048]: `%s` threw an exception\n", row.name);
    }
    (void)std::fflush(stdout);
  }

  [[noreturn]] void serve(std::size_t k) {
    Channel& c = shared_.channel(module_, k);
    const std::uint32_t theirs = 2 * generation_, mine = theirs + 1;
    std::string bytes, reply;
    own_culprit = &state().culprit;
    own_channel = static_cast<std::uint32_t>(k + 1);
    // For a handler when the stack is full.
    std::vector<std::byte> more_stack(1 << 16);
    stack_t handlers{};
    handlers.ss_sp = more_stack.data();
    handlers.ss_size = more_stack.size();
    (void)::sigaltstack(&handlers, nullptr);
    while (true) {
      bytes.clear();
      if (shared_.receive(c, mine, theirs, bytes, {}) != Wait::MyTurn) ::_exit(0);
      Taker taker(bytes);
      see_posters(taker);
      Call call{.owner = c.owner, .report = c.report, .in = std::string(taker.rest())};
      execute(c.function, call);
      state().served.fetch_add(1);
      reply.clear();
      show_posters(reply);
      const bool has_owner = call.owner >= 0;
      append_text(reply, has_owner ? activity_notes().take(description_.owners[index(call.owner)].name) : "");
      append_text(reply, has_owner ? service_notes().take(description_.owners[index(call.owner)].service) : "");
      reply += call.out;
      c.answer = call.answer;
      c.report = call.report;
      if (shared_.send(c, mine, theirs, reply, {}) != Wait::MyTurn) ::_exit(0);
    }
  }
  // Those of a call that was sent before another one may arrive after it.
  void see_posters(Taker& taker) {
    std::uint32_t count = 0;
    (void)taker.take(count);
    const std::lock_guard<std::mutex> hold(lock_);
    for (; count > 0; --count) {
      std::uint32_t poster = 0;
      std::uint64_t version = 0;
      std::string_view value;
      if (!taker.take(poster) || !taker.take(version) || !taker.take_text(value)) return;
      if (version > told_[poster] && description_.posters[poster].unpack(value)) told_[poster] = version;
    }
  }
  void show_posters(std::string& out) {
    std::uint32_t count = 0;
    const std::size_t at = out.size();
    append(out, count);
    const std::lock_guard<std::mutex> hold(lock_);
    for (std::size_t k = 0; k < description_.posters.size(); ++k) {
      const PosterRow& poster = description_.posters[k];
      if (poster.writer != static_cast<int>(module_) || poster.version() == told_[k]) continue;
      std::string value;
      told_[k] = poster.pack(value);
      append(out, static_cast<std::uint32_t>(k));
      append(out, told_[k]);
      append_text(out, value);
      ++count;
    }
    std::memcpy(out.data() + at, &count, sizeof count);
  }

  const Description& description_;
  Channels& shared_;
  const std::size_t module_;
  const std::uint32_t generation_;
  std::mutex lock_;                  // of `told_`
  std::vector<std::uint64_t> told_;  // versions of the posters that were sent to it or by it
  static inline ModuleProcess* own_process = nullptr;
};

}  // namespace bip::processes
