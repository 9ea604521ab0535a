// Codels of each robot module in a process of its own (`bipc genom --processes`): a codel that crashes, exits or hangs
// ends its module, and nothing else. Header only; Linux.
//
//   controller --commands--> nursery --forks--> one process per module
//        \______________ channels: shared memory ______________/
//
// The nursery is forked before the first codel runs and never runs one itself, so whatever it forks has fresh data.
// This is the controller's side; codel_nursery.hpp and codel_module.hpp have the others'. codel_channels.hpp has the
// memory that all share, and how a call gets from one side to the other.
//
// Posters that other modules read go through the controller: with a reply those that the module has written, with a
// call those that the module reads and has not seen. Cost of a call: two switches of processes.
#pragma once
#include <fcntl.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "bip/codel_calls.hpp"
#include "bip/codel_channels.hpp"
#include "bip/codel_nursery.hpp"
#include "bip/codels.hpp"

namespace bip::processes {

// ---- the level

class Level {
 public:
  explicit Level(const Description& description)
      : description_(description),
        books_(description_.modules.size()),
        accepted_(description_.owners.size()),
        deaths_without_trace_(description_.owners.size()) {
    // One for each codel that may run at a time, and for what others ask meanwhile.
    std::vector<std::size_t> owners(description_.modules.size());
    for (const OwnerRow& row : description_.owner_rows) ++owners[index(row.module)];
    for (const std::size_t count : owners) width_ = std::max(width_, count + 3);
    for (Book& book : books_) {
      book.is_taken.resize(width_);
      book.sent.resize(description_.posters.size());
      book.heard.resize(description_.posters.size());
    }
  }
  Level(const Level&) = delete;
  Level& operator=(const Level&) = delete;
  /// Ends the processes of all modules.
  ~Level() {
    if (nursery_ <= 0 || own_pid_ != ::getpid()) return;
    {
      const std::lock_guard<std::mutex> hold(nursery_lock_);
      ends_ = true;
      (void)::shutdown(commands_, SHUT_RDWR);
    }
    listener_.join();
    ::close(commands_);
    (void)::waitpid(nursery_, nullptr, 0);
  }

  /// An activity is accepted: from now on its codels run in the process that its module has now, or fail.
  void accepted(int owner) {
    if (!start()) return;
    const OwnerRow& row = description_.owner_rows[index(owner)];
    notice_death(row.module);
    const std::lock_guard<std::mutex> hold(lock_);
    const std::uint32_t generation = state(row.module).generation;
    Book& book = books_[index(row.module)];
    Acceptance& activity = accepted_[index(owner)];
    // What has judged or taken its input may be gone.
    const bool is_stale = (activity.asked_in != 0 && activity.asked_in != generation) ||
                          (book.input_in != 0 && book.input_in != generation);
    const bool needs_init = description_.modules[index(row.module)].needs_init && !row.is_init;
    activity = {.runs_in = is_stale ? kNever : generation,
                .lacks_init = needs_init && book.initialised_in != generation};
    book.input_in = 0;
  }

  /// A codel of an activity or a task.
  int step(int function, int owner, int& report) {
    const OwnerRow& row = description_.owner_rows[index(owner)];
    Call call{.owner = owner, .report = report};
    std::uint32_t generation = 0;
    Outcome outcome;
    if (!row.is_task) {
      const std::lock_guard<std::mutex> hold(lock_);
      generation = accepted_[index(owner)].runs_in;
      if (accepted_[index(owner)].lacks_init) outcome.why = "its module was started again and waits for its init";
    }
    if (outcome.why.empty()) outcome = run(function, row.module, generation, call);
    if (!outcome.why.empty()) {
      tell_failure(function, owner, row.is_task ? nullptr : &activity_notes(), description_.owners[index(owner)].name,
                   outcome);
      return kCodelThrew;
    }
    report = call.report;
    if (row.is_init && call.answer != kCodelThrew && call.report == 0) {
      const std::lock_guard<std::mutex> hold(lock_);
      books_[index(row.module)].initialised_in = outcome.generation;
    }
    return call.answer;
  }

  /// A codel that judges or does a request at once, or of a task.
  int control(int function, int owner, std::string in = {}) {
    const OwnerRow& row = description_.owner_rows[index(owner)];
    Call call{.owner = owner, .in = std::move(in)};
    const Outcome outcome = run(function, row.module, 0, call);
    if (!outcome.why.empty()) {
      tell_failure(function, owner, row.is_task ? nullptr : &service_notes(), description_.owners[index(owner)].service,
                   outcome);
      return kCodelRefuses;
    }
    const std::lock_guard<std::mutex> hold(lock_);
    accepted_[index(owner)].asked_in = outcome.generation;
    if (call.answer == 0 && description_.functions[index(function)].is_repeated)
      books_[index(row.module)].repeat({function, owner, std::move(call.in)});
    return call.answer;
  }

  /// Another function of a module. Nothing if its process has died, of which the log tells.
  std::optional<std::string> call(int function, int module, std::string in, int owner = -1) {
    Call call{.owner = owner, .in = std::move(in)};
    const Outcome outcome = run(function, module, 0, call);
    if (outcome.why.empty()) return std::move(call.out);
    std::fprintf(stderr, "warning[R0050]: `%s` of module %s: %s\n", description_.functions[index(function)].name,
                 description_.modules[index(module)].name, outcome.why.c_str());
    stop_robot(outcome, function, description_.modules[index(module)].name);
    return std::nullopt;
  }
  /// What owner's service was asked with goes to its module.
  void call_of(int owner, int function, std::string in = {}) {
    (void)call(function, description_.owner_rows[index(owner)].module, std::move(in), owner);
  }
  /// Two texts, of which the first one begins with the module's name and a dot. Nothing: there is no such module.
  std::optional<std::string> call_by_name(int function, const char* name, const char* more) {
    const std::string_view module = std::string_view(name).substr(0, std::string_view(name).find('.'));
    for (std::size_t m = 0; m < description_.modules.size(); ++m) {
      if (module != description_.modules[m].name) continue;
      std::string in;
      append_text(in, name);
      append_text(in, more);
      return call(function, static_cast<int>(m), std::move(in));
    }
    return std::nullopt;
  }
  /// The input of a request that is accepted next.
  void give_input(int function, const char* service, const char* input) {
    const std::string_view module = std::string_view(service).substr(0, std::string_view(service).find('.'));
    if (!start()) return;
    for (std::size_t m = 0; m < description_.modules.size(); ++m) {
      if (module != description_.modules[m].name) continue;
      const std::lock_guard<std::mutex> hold(lock_);
      books_[m].input_in = shared_.state(m).generation;
    }
    (void)call_by_name(function, service, input);
  }

  /// Called with the reason when a process has died; on the thread that notices it. May be null.
  std::atomic<void (*)(const char* why)> on_death{nullptr};

 private:
  static constexpr std::uint32_t kNever = UINT32_MAX;

  // A call that each process of a module has to have had.
  struct Repeated {
    int function = 0, owner = 0;
    std::string in{};
  };
  // Of an activity: the generations of its module in which its input was judged, and in which it may run.
  struct Acceptance {
    std::uint32_t runs_in = 0, asked_in = 0;
    bool lacks_init = false;
  };
  // What the controller knows of a module: which death it has noticed, and numbers of posters in this generation.
  struct Book {
    std::uint32_t seen = 1, initialised_in = 0, input_in = 0, posters_of = 1;
    std::vector<bool> is_taken{};  // by channel
    std::vector<std::uint64_t> sent{}, heard{};
    std::vector<Repeated> repeated{};
    std::uint32_t repeated_in = 1;
    std::mutex repeating{};  // of whose calls are made again
    // The same call is made once, after all others.
    void repeat(Repeated call) {
      std::erase_if(repeated, [&](const Repeated& r) {
        return r.function == call.function && r.owner == call.owner && r.in == call.in;
      });
      repeated.push_back(std::move(call));
    }
  };
  // `why`: it failed, so; `is_death`: because the process has died meanwhile.
  struct Outcome {
    std::string why{};
    bool is_death = false;
    std::uint32_t generation = 0;
  };

  static std::size_t index(int number) { return static_cast<std::size_t>(number); }
  [[nodiscard]] ModuleState& state(int module) const { return shared_.state(index(module)); }
  [[nodiscard]] Channel& channel(int module, std::size_t k) const { return shared_.channel(index(module), k); }

  // ---- the controller's side: failures

  void tell_failure(int function, int owner, ReplyNotes* notes, const char* whose, const Outcome& outcome) {
    const char* const codel = description_.functions[index(function)].name;
    const char* const name = description_.owners[index(owner)].name;
    std::fprintf(stderr, "warning[R0050]: codel `%s` of %s: %s\n", codel, name, outcome.why.c_str());
    if (notes != nullptr && *whose != '\0')
      notes->note(whose, "\"exception\":{\"codel\":" + json_text(codel) + ",\"what\":" + json_text(outcome.why) + "}");
    stop_robot(outcome, function, name);
  }
  void stop_robot(const Outcome& outcome, int function, const char* whose) {
    void (*const hook)(const char*) = on_death.load();
    if (!outcome.is_death || hook == nullptr) return;
    hook((std::string("`") + description_.functions[index(function)].name + "` of " + whose + ": " + outcome.why)
             .c_str());
  }
  [[nodiscard]] std::string death_of(int module) const {
    return "the process of module " + std::string(description_.modules[index(module)].name) + " " +
           death_text(state(module).status);
  }
  // A process may die between two calls. Whose call has ended it tells of that; a call that is on its way is left to
  // its caller.
  enum class Calls { AreNone, MayBe };
  void notice_death(int module, Calls calls = Calls::MayBe) {
    {
      const std::lock_guard<std::mutex> hold(lock_);
      const Book& book = books_[index(module)];
      if (calls == Calls::AreNone && std::find(book.is_taken.begin(), book.is_taken.end(), true) != book.is_taken.end())
        return;
      const std::uint32_t generation = state(module).generation;
      if (std::exchange(books_[index(module)].seen, generation) == generation) return;
    }
    if (state(module).ended_by != 0) return;
    const std::string why = death_of(module);
    std::fprintf(stderr, "warning[R0050]: %s\n", why.c_str());
    if (void (*const hook)(const char*) = on_death.load(); hook != nullptr) hook(why.c_str());
  }

  // ---- the controller's side: calls

  Outcome run(int function, int module, std::uint32_t required, Call& call) {
    // What it takes here is what the level waits for: with both switches.
    std::optional<CodelTimer> timer;
    if (description_.functions[index(function)].is_codel) timer.emplace(description_.functions[index(function)].name);
    if (!start()) return {.why = "no process can be started"};
    // A task goes on in another process, if not its own codel has ended this one.
    const bool is_task = call.owner >= 0 && description_.owner_rows[index(call.owner)].is_task;
    while (true) {
      notice_death(module);
      const std::uint32_t generation = state(module).generation;
      if (required != 0 && required != generation) return {.why = "the process of its module was started again"};
      if (state(module).pid == 0) command('s', module, generation);
      const std::size_t k = take_channel(module);
      Wait end = repeat_calls(module, generation, channel(module, k));
      const bool has_begun = end == Wait::MyTurn ? exchange(function, module, generation, channel(module, k), call, end)
                                                 : end == Wait::TooLate;
      if (end == Wait::MyTurn || !has_begun) {
        free_channel(module, k);
        if (has_begun) return {.generation = generation};
        continue;
      }
      Outcome outcome{.is_death = true, .generation = generation};
      if (end == Wait::TooLate) {
        outcome.why = "the process of module " + std::string(description_.modules[index(module)].name) +
                      " did not answer for " + std::to_string(description_.functions[index(function)].limit_ms) +
                      " ms and was ended";
        state(module).culprit = static_cast<std::uint32_t>(k + 1);
        while (state(module).generation == generation) {
          command('k', module, generation);
          watch_nursery();
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
      } else {
        const std::uint32_t culprit = state(module).ended_by;
        if (is_task && culprit != k + 1 && (culprit != 0 || may_go_on(call.owner))) {
          free_channel(module, k);
          continue;
        }
        outcome.why = death_of(module);
      }
      {
        const std::lock_guard<std::mutex> hold(lock_);
        books_[index(module)].seen = std::max(books_[index(module)].seen, generation + 1);
      }
      free_channel(module, k);
      return outcome;
    }
  }

  // If nothing tells what has ended the process of a task (SIGKILL when there is no memory, `_exit`), it goes on, but
  // not for the fourth time in a minute: then its own codel is what does it.
  bool may_go_on(int task) {
    constexpr std::size_t kMost = 3;
    const std::lock_guard<std::mutex> hold(lock_);
    std::vector<Clock::time_point>& deaths = deaths_without_trace_[index(task)];
    const Clock::time_point now = Clock::now();
    std::erase_if(deaths, [&](Clock::time_point death) { return now - death > std::chrono::minutes(1); });
    if (deaths.size() == kMost) return false;
    deaths.push_back(now);
    return true;
  }

  // Calls to earlier processes of the module are repeated before any other call.
  Wait repeat_calls(int module, std::uint32_t generation, Channel& c) {
    Book& book = books_[index(module)];
    const auto is_done = [&] {
      const std::lock_guard<std::mutex> hold(lock_);
      return book.repeated.empty() || book.repeated_in == generation;
    };
    if (is_done()) return Wait::MyTurn;
    const std::lock_guard<std::mutex> repeating(book.repeating);
    if (is_done()) return Wait::MyTurn;
    std::vector<Repeated> calls;
    {
      const std::lock_guard<std::mutex> hold(lock_);
      calls = book.repeated;
    }
    for (Repeated& r : calls) {
      Call call{.owner = r.owner, .in = std::move(r.in)};
      Wait end = Wait::Died;
      if (!exchange(r.function, module, generation, c, call, end)) return Wait::Died;
      if (end != Wait::MyTurn) return end;
    }
    const std::lock_guard<std::mutex> hold(lock_);
    book.repeated_in = generation;
    return Wait::MyTurn;
  }

  std::size_t take_channel(int module) {
    const std::lock_guard<std::mutex> hold(lock_);
    std::vector<bool>& taken = books_[index(module)].is_taken;
    // There are more channels than codels and other functions that may be called at a time.
    std::size_t k = 0;
    while (k + 1 < taken.size() && taken[k]) ++k;
    taken[k] = true;
    ModuleState& s = state(module);
    if (s.threads < k + 1) {
      s.threads = static_cast<std::uint32_t>(k + 1);
      wake_all(s.threads);
    }
    return k;
  }
  void free_channel(int module, std::size_t k) {
    const std::lock_guard<std::mutex> hold(lock_);
    books_[index(module)].is_taken[k] = false;
  }

  // False: the process had died before it got the call.
  bool exchange(int function, int module, std::uint32_t generation, Channel& c, Call& call, Wait& end) {
    const FunctionRow& row = description_.functions[index(function)];
    std::optional<Clock::time_point> deadline;
    if (row.limit_ms > 0) deadline = Clock::now() + std::chrono::milliseconds(row.limit_ms);
    const std::uint32_t mine = 2 * generation, theirs = mine + 1;
    if (c.turn != mine) return false;
    c.function = function;
    c.owner = call.owner;
    c.report = call.report;
    std::string bytes;
    pack_posters(module, generation, bytes);
    bytes += call.in;
    end = send(c, mine, theirs, bytes, deadline);
    if (end == Wait::Died) return false;
    std::string reply;
    if (end == Wait::MyTurn) end = receive(c, mine, theirs, reply, deadline);
    while (end == Wait::MyTurn && c.function == kAsksForService) {
      c.function = function;
      const std::string answer = ask_for_service(reply);
      reply.clear();
      end = send(c, mine, theirs, answer, deadline);
      if (end == Wait::MyTurn) end = receive(c, mine, theirs, reply, deadline);
      else if (end == Wait::Died) return true;
    }
    if (end != Wait::MyTurn) return true;
    call.answer = c.answer;
    call.report = c.report;
    Taker taker(reply);
    std::string_view activity, service;
    if (!unpack_posters(module, generation, taker) || !taker.take_text(activity) || !taker.take_text(service)) {
      // It has written over what it shares with us: its own fault.
      command('k', module, generation);
      end = wait(c.turn, mine, 0, {});
      return true;
    }
    if (call.owner >= 0) {
      const CodelOwner& owner = description_.owners[index(call.owner)];
      if (!activity.empty()) activity_notes().note(owner.name, std::string(activity));
      if (!service.empty()) service_notes().note(owner.service, std::string(service));
    }
    call.out = taker.rest();
    return true;
  }

  static std::string ask_for_service(std::string_view question) {
    Taker taker(question);
    std::string_view service, input;
    const ServiceCaller caller = service_caller().load();
    if (caller == nullptr || !taker.take_text(service) || !taker.take_text(input)) return "{}";
    return caller(std::string(service).c_str(), std::string(input).c_str());
  }

  // Those that this process has not seen.
  void pack_posters(int module, std::uint32_t generation, std::string& out) {
    std::uint32_t count = 0;
    const std::size_t at = out.size();
    append(out, count);
    if (description_.readers.empty()) return;
    const std::lock_guard<std::mutex> hold(lock_);
    Book& book = books_[index(module)];
    renew(book, generation);
    for (const ReaderRow& reader : description_.readers) {
      if (reader.module != module) continue;
      const PosterRow& poster = description_.posters[index(reader.poster)];
      std::uint64_t& sent = book.sent[index(reader.poster)];
      if (poster.version() == sent) continue;
      std::string value;
      sent = poster.pack(value);
      append(out, static_cast<std::uint32_t>(reader.poster));
      append(out, sent);
      append_text(out, value);
      ++count;
    }
    std::memcpy(out.data() + at, &count, sizeof count);
  }
  bool unpack_posters(int module, std::uint32_t generation, Taker& taker) {
    std::uint32_t count = 0;
    if (!taker.take(count)) return false;
    const std::lock_guard<std::mutex> hold(lock_);
    Book& book = books_[index(module)];
    renew(book, generation);
    for (; count > 0; --count) {
      std::uint32_t poster = 0;
      std::uint64_t version = 0;
      std::string_view value;
      if (!taker.take(poster) || !taker.take(version) || !taker.take_text(value) ||
          poster >= description_.posters.size() || description_.posters[poster].writer != module)
        return false;
      if (version <= book.heard[poster]) continue;
      if (!description_.posters[poster].unpack(value)) return false;
      book.heard[poster] = version;
    }
    return true;
  }
  static void renew(Book& book, std::uint32_t generation) {
    if (std::exchange(book.posters_of, generation) == generation) return;
    std::fill(book.sent.begin(), book.sent.end(), 0);
    std::fill(book.heard.begin(), book.heard.end(), 0);
  }

  // ---- both sides

  Wait wait(std::atomic<std::uint32_t>& turn, std::uint32_t theirs, std::uint32_t mine,
            const std::optional<Clock::time_point>& deadline) {
    return shared_.wait(turn, theirs, mine, deadline);
  }
  Wait send(Channel& c, std::uint32_t mine, std::uint32_t theirs, std::string_view bytes,
            const std::optional<Clock::time_point>& deadline) {
    return shared_.send(c, mine, theirs, bytes, deadline);
  }
  Wait receive(Channel& c, std::uint32_t mine, std::uint32_t theirs, std::string& bytes,
               const std::optional<Clock::time_point>& deadline) {
    return shared_.receive(c, mine, theirs, bytes, deadline);
  }

  // ---- the controller's side: processes

  bool start() {
    std::call_once(begun_, [this] {
      if (!shared_.map(description_.modules.size(), width_)) return;
      shared_.while_waiting = [this] { watch_nursery(); };
      own_pid_ = ::getpid();
      open_nursery();
      if (nursery_ > 0) listener_ = std::thread([this] { listen(); });
    });
    return nursery_ > 0;
  }

  // The nursery sends a byte when a process has died; the end of its bytes is its own. So a death is noticed at once,
  // also if no call is due for a long time.
  void listen() {
    while (true) {
      int socket = -1;
      {
        const std::lock_guard<std::mutex> hold(nursery_lock_);
        if (ends_ || nursery_ <= 0) return;
        // Its number may be another file's after watch_nursery().
        socket = ::fcntl(commands_, F_DUPFD_CLOEXEC, 0);
      }
      if (socket < 0) return;
      char byte = 0;
      ssize_t size = 0;
      while ((size = ::recv(socket, &byte, sizeof byte, 0)) > 0 || (size < 0 && errno == EINTR)) notice_deaths();
      ::close(socket);
      watch_nursery();
      notice_deaths();
    }
  }
  void notice_deaths() {
    for (std::size_t m = 0; m < description_.modules.size(); ++m) notice_death(static_cast<int>(m), Calls::AreNone);
  }

  void open_nursery() {
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) return;
    // What is buffered belongs to the controller.
    (void)std::fflush(stdout);
    const pid_t child = ::fork();
    if (child == 0) {
      ::close(ends[0]);
      Nursery(description_, shared_).run(ends[1]);
    }
    ::close(ends[1]);
    if (child < 0) {
      ::close(ends[0]);
      return;
    }
    commands_ = ends[0];
    nursery_ = child;
    for (std::size_t m = 0; m < description_.modules.size(); ++m)
      send_command('s', static_cast<int>(m), shared_.state(m).generation);
  }

  // The listener may be replacing the nursery: then the number of its socket may be another file's.
  void command(char what, int module, std::uint32_t generation) {
    const std::lock_guard<std::mutex> hold(nursery_lock_);
    send_command(what, module, generation);
  }
  void send_command(char what, int module, std::uint32_t generation) {
    const NurseryCommand message{what, module, generation};
    (void)::send(commands_, &message, sizeof message, MSG_NOSIGNAL);
  }

  // If it has died, all modules have: another one.
  void watch_nursery() {
    const std::lock_guard<std::mutex> hold(nursery_lock_);
    if (ends_) return;
    const pid_t ended = ::waitpid(nursery_, nullptr, WNOHANG);
    if (ended == 0 || (ended < 0 && errno != ECHILD)) return;
    ::close(commands_);
    for (std::size_t m = 0; m < description_.modules.size(); ++m) shared_.note_end(m, SIGKILL);
    open_nursery();
  }

  const Description description_;
  std::mutex lock_;          // of books and acceptances
  std::mutex nursery_lock_;  // of what is needed to talk to it
  std::vector<Book> books_;
  std::vector<Acceptance> accepted_;
  std::vector<std::vector<Clock::time_point>> deaths_without_trace_;  // by owner, if it is a task
  std::size_t width_ = 3;                                             // channels of a module
  Channels shared_;
  std::once_flag begun_;
  std::thread listener_;
  bool ends_ = false;
  int commands_ = -1;
  std::atomic<pid_t> nursery_ = 0;
  pid_t own_pid_ = 0;
};

}  // namespace bip::processes
