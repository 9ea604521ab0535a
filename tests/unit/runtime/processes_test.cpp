// Codels in processes of their own (bip/codel_processes.hpp), without bipc around them: calls, posters, deaths.
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "bip/codel_processes.hpp"
#include "bip/shared_object.hpp"

using namespace bip::processes;

namespace {

int ids = 0;  // of a module: each process has its own
std::string poster;
std::atomic<std::uint64_t> poster_version{0};

struct Meeting {
  std::atomic<int> arrived{0};
  std::atomic<bool> waits{false};
};
const bip::SharedObject<Meeting> kMeeting;

constexpr bip::CodelOwner kOwners[] = {{"a.Go", "a.Go"}, {"a.Init", "a.Init"}, {"task a.T", ""}, {"b.Go", "b.Go"}};
constexpr OwnerRow kOwnerRows[] = {{0, false, false}, {0, false, true}, {0, true, false}, {1, false, false}};
enum Owner : int { kGo, kInit, kTask, kOther };
constexpr ModuleRow kPlain[] = {{"a", false}, {"b", false}};
constexpr ModuleRow kWithInit[] = {{"a", true}, {"b", false}};

enum Function : int {
  kCount,
  kCrash,
  kExit,
  kHang,
  kEcho,
  kWrite,
  kRead,
  kMeet,
  kPid,
  kGrow,
  kStart,
  kLinger,
  kCrashBeside,
  kNote,
  kVanish,
  kLeave,
  kParent
};
constexpr FunctionRow kFunctions[] = {
    {"count", 0, [](Call& call) { call.answer = ++ids; }},
    {"crash", 0, [](Call&) { (void)::raise(SIGSEGV); }},
    {"exit", 0, [](Call&) { std::exit(7); }},
    {"hang", 30, [](Call&) { std::this_thread::sleep_for(std::chrono::seconds(60)); }},
    {"echo", 0, [](Call& call) { call.out = call.in + call.in; }},
    {"write", 0,
     [](Call& call) {
       poster = call.in;
       ++poster_version;
     }},
    {"read", 0, [](Call& call) { call.out = poster; }},
    // Returns when two are there at a time.
    {"meet", 0,
     [](Call& call) {
       for (++kMeeting->arrived; kMeeting->arrived < 2;) std::this_thread::sleep_for(std::chrono::milliseconds(1));
       call.answer = 1;
     }},
    {"pid", 0, [](Call& call) { append(call.out, ::getpid()); }},
    {"grow", 0,
     [](Call& call) {
       void* volatile memory = std::malloc(std::size_t{512} << 20);
       call.answer = memory == nullptr ? 1 : 2;
       std::free(memory);
     }},
    {"start", 0, [](Call&) { ids = 100; }},
    // Stays in the first process for ever, in another one not at all.
    {"linger", 0,
     [](Call& call) {
       if (!kMeeting->waits.exchange(true)) std::this_thread::sleep_for(std::chrono::seconds(600));
       call.answer = 5;
     }},
    {"crash beside", 0,
     [](Call&) {
       while (!kMeeting->waits) std::this_thread::sleep_for(std::chrono::milliseconds(1));
       (void)::raise(SIGSEGV);
     }},
    {"note", 0, [](Call& call) { bip::activity_notes().note(kOwners[call.owner].name, "\"output\":1"); }},
    {"vanish", 0, [](Call&) { (void)::raise(SIGKILL); }},
    {"leave", 0, [](Call&) { ::_exit(3); }},
    {"parent", 0, [](Call& call) { append(call.out, ::getppid()); }},
};
constexpr StartRow kStarts[] = {{kStart, kTask}};
constexpr PosterRow kPosters[] = {{.writer = 0,
                                   .pack =
                                       [](std::string& out) {
                                         out += poster;
                                         return poster_version.load();
                                       },
                                   .version = [] { return poster_version.load(); },
                                   .unpack =
                                       [](std::string_view in) {
                                         poster = in;
                                         ++poster_version;
                                         return true;
                                       }}};
constexpr ReaderRow kReaders[] = {{1, 0}};

Description plain() {
  return {.modules = kPlain, .owners = kOwners, .owner_rows = kOwnerRows, .functions = kFunctions};
}
int step(Level& level, Function function, Owner owner) {
  int report = 0;
  return level.step(function, owner, report);
}
std::string exception_of(Owner owner) { return bip::activity_notes().take(kOwners[owner].name); }
pid_t pid_of(Level& level, int module) {
  pid_t pid = 0;
  const auto bytes = level.call(kPid, module, {});
  return bytes && Taker(*bytes).take(pid) ? pid : 0;
}
bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

// What `on_death` was called with, on whichever thread.
class HeardDeaths {
 public:
  void clear() {
    const std::lock_guard<std::mutex> hold(lock_);
    texts_.clear();
  }
  void note(const char* text) {
    const std::lock_guard<std::mutex> hold(lock_);
    texts_.emplace_back(text);
  }
  std::size_t count() {
    const std::lock_guard<std::mutex> hold(lock_);
    return texts_.size();
  }
  /// All, a line each, when there are `number`, or after a minute.
  std::string wait(std::size_t number = 1) {
    for (int k = 0; k < 60000 && count() < number; ++k) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const std::lock_guard<std::mutex> hold(lock_);
    std::string all;
    for (const std::string& text : texts_) all += all.empty() ? text : "\n" + text;
    return all;
  }

 private:
  std::mutex lock_;
  std::vector<std::string> texts_;
};

}  // namespace

TEST_CASE("each module has data of its own, in its own process") {
  Level level(plain());
  CHECK(step(level, kCount, kGo) == 1);
  CHECK(step(level, kCount, kTask) == 2);
  CHECK(step(level, kCount, kOther) == 1);
  CHECK(level.control(kCount, kInit) == 3);
  CHECK(ids == 0);
  CHECK(pid_of(level, 0) != pid_of(level, 1));
  CHECK(pid_of(level, 0) == pid_of(level, 0));
  CHECK(step(level, kNote, kGo) == 0);
  CHECK(exception_of(kGo) == "\"output\":1");
}

TEST_CASE("a call may bring and take more than a channel holds") {
  Level level(plain());
  for (const std::size_t size : {std::size_t{0}, kChunk - 4, kChunk, 3 * kChunk, 20 * kChunk + 1}) {
    std::string text(size, 'x');
    for (std::size_t k = 0; k < size; k += 7) text[k] = static_cast<char>('a' + k % 26);
    const auto twice = level.call(kEcho, 0, text);
    REQUIRE(twice.has_value());
    CHECK(*twice == text + text);
  }
}

TEST_CASE("calls of one module run at a time") {
  Level level(plain());
  CHECK(step(level, kCount, kOther) == 1);  // the processes are there before the thread
  int other = 0;
  std::thread beside([&] { other = step(level, kMeet, kTask); });
  CHECK(step(level, kMeet, kGo) == 1);
  beside.join();
  CHECK(other == 1);
}

TEST_CASE("a process that dies fails its activities, and starts again with fresh data") {
  Level level(plain());
  static std::vector<std::string> whys;
  whys.clear();
  level.on_death = [](const char* why) { whys.emplace_back(why); };
  level.accepted(kGo);
  level.accepted(kOther);
  CHECK(step(level, kCount, kGo) == 1);
  CHECK(step(level, kCount, kOther) == 1);
  const auto [function, text] = GENERATE(std::pair(kCrash, "ended by SIGSEGV"), std::pair(kExit, "ended by exit(7)"),
                                         std::pair(kHang, "did not answer for 30 ms and was ended"));
  CHECK(step(level, function, kTask) == bip::kCodelThrew);
  REQUIRE(whys.size() == 1);
  CHECK(contains(whys[0], text));
  CHECK(contains(whys[0], "`" + std::string(kFunctions[function].name) + "` of task a.T"));
  // Its data is gone.
  CHECK(step(level, kCount, kGo) == bip::kCodelThrew);
  CHECK(contains(exception_of(kGo), "\"what\":\"the process of its module was started again\""));
  CHECK(step(level, kCount, kTask) == 1);
  // A new one runs, the other module has not noticed anything.
  level.accepted(kGo);
  CHECK(step(level, kCount, kGo) == 2);
  CHECK(step(level, kCount, kOther) == 2);
  CHECK(whys.size() == 1);
  CHECK(level.control(function, kGo) == bip::kCodelRefuses);
  CHECK(contains(bip::service_notes().take("a.Go"), text));
}

TEST_CASE("a death between two calls is noticed, without a call") {
  Level level(plain());
  static HeardDeaths heard;
  heard.clear();
  level.on_death = [](const char* text) { heard.note(text); };
  level.accepted(kGo);
  const pid_t before = pid_of(level, 0);
  REQUIRE(before > 1);
  REQUIRE(::kill(before, SIGKILL) == 0);
  CHECK(heard.wait() == "the process of module a ended by SIGKILL");
  // Its data is gone; its death is reported once.
  CHECK(step(level, kCount, kGo) == bip::kCodelThrew);
  CHECK(pid_of(level, 0) != before);
  CHECK(heard.count() == 1);
}

TEST_CASE("a task goes on three times when its process dies without a trace") {
  Level level(plain());
  static HeardDeaths heard;
  heard.clear();
  level.on_death = [](const char* text) { heard.note(text); };
  CHECK(step(level, kCount, kTask) == 1);
  const auto [function, text] = GENERATE(std::pair(kVanish, "ended by SIGKILL"), std::pair(kLeave, "ended by exit(3)"));
  // Its codel ends the next processes, too.
  CHECK(step(level, function, kTask) == bip::kCodelThrew);
  const std::string deaths = heard.wait(4);
  CHECK(contains(deaths, std::string("the process of module a ") + text));
  CHECK(contains(deaths, std::string("of task a.T: the process of module a ") + text));
  CHECK(step(level, kCount, kTask) == 1);
  CHECK(heard.count() == 4);
}

TEST_CASE("the process that starts the others is replaced, without a call") {
  Level level(plain());
  static HeardDeaths heard;
  heard.clear();
  level.on_death = [](const char* text) { heard.note(text); };
  pid_t nursery = 0;
  const auto bytes = level.call(kParent, 0, {});
  REQUIRE((bytes && Taker(*bytes).take(nursery) && nursery > 1));
  REQUIRE(::kill(nursery, SIGKILL) == 0);
  CHECK(contains(heard.wait(), "ended by SIGKILL"));
  CHECK(step(level, kCount, kTask) == 1);
  CHECK(step(level, kCount, kOther) == 1);
}

TEST_CASE("a task goes on when something else has ended its process") {
  Level level(plain());
  static std::atomic<int> deaths{0};
  deaths = 0;
  level.on_death = [](const char*) { ++deaths; };
  level.accepted(kGo);
  CHECK(step(level, kCount, kGo) == 1);
  kMeeting->waits = false;
  int task = 0;
  std::thread beside([&] { task = step(level, kLinger, kTask); });
  CHECK(step(level, kCrashBeside, kGo) == bip::kCodelThrew);
  beside.join();
  CHECK(task == 5);
  CHECK(deaths == 1);
  CHECK(contains(exception_of(kGo), "ended by SIGSEGV"));
  // Nobody of the module has ended this one.
  kMeeting->waits = false;
  std::thread again([&] { task = step(level, kLinger, kTask); });
  while (!kMeeting->waits) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  REQUIRE(::kill(pid_of(level, 0), SIGKILL) == 0);
  again.join();
  CHECK(task == 5);
  CHECK(deaths == 2);
}

TEST_CASE("after a restart activities wait for the init of their module") {
  Description description = plain();
  description.modules = kWithInit;
  Level level(description);
  level.accepted(kInit);
  CHECK(step(level, kCount, kInit) == 1);
  level.accepted(kGo);
  CHECK(step(level, kCount, kGo) == 2);
  CHECK(step(level, kCrash, kGo) == bip::kCodelThrew);
  (void)exception_of(kGo);
  level.accepted(kGo);
  CHECK(step(level, kCount, kGo) == bip::kCodelThrew);
  CHECK(contains(exception_of(kGo), "waits for its init"));
  level.accepted(kInit);
  CHECK(step(level, kCount, kInit) == 1);
  level.accepted(kGo);
  CHECK(step(level, kCount, kGo) == 2);
}

TEST_CASE("a process that starts again runs the start codels of its tasks first") {
  Description description = plain();
  description.starts = kStarts;
  Level level(description);
  CHECK(step(level, kCount, kTask) == 1);
  CHECK(step(level, kCrash, kTask) == bip::kCodelThrew);
  CHECK(step(level, kCount, kTask) == 101);
  CHECK(step(level, kCount, kOther) == 1);
}

TEST_CASE("posters reach the modules that read them") {
  Description description = plain();
  description.posters = kPosters;
  description.readers = kReaders;
  Level level(description);
  CHECK(level.call(kRead, 1, {}) == "");
  CHECK(level.call(kWrite, 0, "here"));
  CHECK(poster == "here");
  CHECK(level.call(kRead, 1, {}) == "here");
  const std::string large(3 * kChunk, 'p');
  CHECK(level.call(kWrite, 0, large));
  CHECK(level.call(kRead, 1, {}) == large);
  // The last value outlives its writer; a reader that has started again gets it, too.
  CHECK_FALSE(level.call(kCrash, 0, {}));
  CHECK_FALSE(level.call(kCrash, 1, {}));
  CHECK(level.call(kRead, 1, {}) == large);
  CHECK(level.call(kWrite, 0, "there"));
  CHECK(level.call(kRead, 1, {}) == "there");
  poster.clear();
}

// A sanitizer's allocator ends the process then; no macro of clang says in each build whether there is one.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(__clang__)
TEST_CASE("a module takes no more memory than it may") {
  Description description = plain();
  Level free(description);
  CHECK(step(free, kGrow, kGo) == 2);
  description.memory_mb = 256;
  Level bound(description);
  CHECK(step(bound, kGrow, kGo) == 1);
}
#endif

TEST_CASE("the processes end with the level") {
  pid_t pid = 0;
  {
    Level level(plain());
    pid = pid_of(level, 0);
    REQUIRE(pid > 1);
  }
  CHECK(::kill(pid, 0) != 0);
}

// Not a test of time: prints what a call costs, with `unit_runtime "[.calls]"`.
TEST_CASE("calls", "[.calls]") {
  Level level(plain());
  double best = 1e9;
  for (int round = 0; round < 20; ++round) {
    const auto begin = std::chrono::steady_clock::now();
    for (int k = 0; k < 5000; ++k) (void)step(level, kCount, kTask);
    best = std::min(best,
                    std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count() / 5000);
  }
  WARN("a call takes " << best << " us (best of 20 times 5000)");
}
