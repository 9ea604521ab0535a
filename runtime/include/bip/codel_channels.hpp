// Memory that a controller shares with the processes of its robot modules, and how calls cross it. Header only; Linux.
// codel_processes.hpp has the processes.
//
// A channel holds one call at a time and belongs to one thread of the module. Its word `turn` is `2 * generation`, plus
// 1 while the module has it; both sides wait on it by futex. When a process has died the nursery raises the module's
// generation and with it all turns, so that neither a caller nor a late write of the dead can take one for the other.
// What is longer than a channel crosses in pieces.
#pragma once
#include <linux/futex.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <climits>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace bip::processes {

inline constexpr std::size_t kChunk = 32768;

struct alignas(64) Channel {
  std::atomic<std::uint32_t> turn{2};
  std::int32_t function = 0, owner = 0, answer = 0, report = 0;
  std::uint32_t size = 0, more = 0;
  char bytes[kChunk];
};
struct alignas(64) ModuleState {
  std::atomic<std::uint32_t> generation{1};
  std::atomic<std::uint32_t> threads{1};  // so many of its channels are in use
  std::atomic<std::uint32_t> served{0};   // calls of this generation
  std::atomic<std::int32_t> pid{0};       // 0: there is none
  std::atomic<std::uint32_t> culprit{0};  // 1 + the channel whose call ends this process; 0: not known
  // Of the last one that has ended: as `wait` has it, and its culprit.
  std::atomic<std::int32_t> status{0};
  std::atomic<std::uint32_t> ended_by{0};
};
static_assert(std::atomic<std::uint32_t>::is_always_lock_free && std::atomic<std::int32_t>::is_always_lock_free,
              "processes share them");

inline long futex(std::atomic<std::uint32_t>& word, int operation, std::uint32_t value, const timespec* timeout) {
  return ::syscall(SYS_futex, reinterpret_cast<std::uint32_t*>(&word), operation, value, timeout, nullptr, 0);
}
inline void wake_all(std::atomic<std::uint32_t>& word) { (void)futex(word, FUTEX_WAKE, INT_MAX, nullptr); }

/// In a module: a thread notes that it is what ends the process.
inline thread_local std::atomic<std::uint32_t>* own_culprit = nullptr;
inline thread_local std::uint32_t own_channel = 0;
/// Instead of the number of a function: the module asks for a service before it answers.
inline constexpr std::int32_t kAsksForService = -1;
inline void note_culprit() {
  if (own_culprit != nullptr) own_culprit->store(own_channel);
}

/// What became of a process, in words.
inline std::string death_text(int status) {
  if (WIFEXITED(status)) return "ended by exit(" + std::to_string(WEXITSTATUS(status)) + ")";
  const int number = WTERMSIG(status);
  const char* const name = ::sigabbrev_np(number);
  return "ended by " + (name == nullptr ? "signal " + std::to_string(number) : "SIG" + std::string(name));
}

enum class Wait { MyTurn, Died, TooLate };
using Clock = std::chrono::steady_clock;

/// The same memory in the controller and in all that are forked after map().
class Channels {
 public:
  /// Called from time to time while the controller waits; a module waits without an end.
  std::function<void()> while_waiting;

  /// False: there is no memory.
  bool map(std::size_t modules, std::size_t width) {
    const std::size_t head = sizeof(ModuleState) * modules;
    void* const place = ::mmap(nullptr, head + sizeof(Channel) * modules * width, PROT_READ | PROT_WRITE,
                               MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (place == MAP_FAILED) return false;
    width_ = width;
    states_ = static_cast<ModuleState*>(place);
    channels_ = reinterpret_cast<Channel*>(static_cast<std::byte*>(place) + head);
    std::uninitialized_default_construct_n(states_, modules);
    std::uninitialized_default_construct_n(channels_, modules * width_);
    return true;
  }
  [[nodiscard]] ModuleState& state(std::size_t module) const { return states_[module]; }
  [[nodiscard]] Channel& channel(std::size_t module, std::size_t k) const { return channels_[module * width_ + k]; }

  /// The process of a module is gone: what waits for it wakes up.
  void note_end(std::size_t module, int status) {
    ModuleState& s = state(module);
    s.status = status;
    s.ended_by = s.culprit.exchange(0);
    s.pid = 0;
    const std::uint32_t next = s.generation + 1;
    s.generation = next;
    for (std::size_t k = 0; k < width_; ++k) {
      channel(module, k).turn = 2 * next;
      wake_all(channel(module, k).turn);
    }
  }

  // Until `turn` is `mine`. `theirs`: what it is meanwhile; anything else means that the process has died.
  Wait wait(std::atomic<std::uint32_t>& turn, std::uint32_t theirs, std::uint32_t mine,
            const std::optional<Clock::time_point>& deadline) {
    while (true) {
      const std::uint32_t now = turn.load(std::memory_order_acquire);
      if (now == mine) return Wait::MyTurn;
      if (now != theirs) return Wait::Died;
      timespec slice{0, 200'000'000};
      if (deadline) {
        const auto left = std::chrono::duration_cast<std::chrono::nanoseconds>(*deadline - Clock::now()).count();
        if (left <= 0) return Wait::TooLate;
        slice.tv_nsec = std::min<long>(slice.tv_nsec, static_cast<long>(left));
      }
      if (futex(turn, FUTEX_WAIT, theirs, while_waiting ? &slice : nullptr) != 0 && errno == ETIMEDOUT) while_waiting();
    }
  }
  // Died: before the first piece has arrived; later deaths are seen by who waits for the answer.
  Wait send(Channel& c, std::uint32_t mine, std::uint32_t theirs, std::string_view bytes,
            const std::optional<Clock::time_point>& deadline) {
    bool is_first = true;
    do {
      const std::size_t size = std::min(bytes.size(), kChunk);
      if (size != 0) std::memcpy(c.bytes, bytes.data(), size);
      bytes.remove_prefix(size);
      c.size = static_cast<std::uint32_t>(size);
      c.more = bytes.empty() ? 0 : 1;
      std::uint32_t now = mine;
      if (!c.turn.compare_exchange_strong(now, theirs, std::memory_order_acq_rel))
        return is_first ? Wait::Died : Wait::MyTurn;
      is_first = false;
      wake_all(c.turn);
      if (bytes.empty()) break;
      if (const Wait end = wait(c.turn, theirs, mine, deadline); end != Wait::MyTurn)
        return end == Wait::Died ? Wait::MyTurn : end;
    } while (true);
    return Wait::MyTurn;
  }
  Wait receive(Channel& c, std::uint32_t mine, std::uint32_t theirs, std::string& bytes,
               const std::optional<Clock::time_point>& deadline) {
    while (true) {
      if (const Wait end = wait(c.turn, theirs, mine, deadline); end != Wait::MyTurn) return end;
      bytes.append(c.bytes, std::min<std::size_t>(c.size, kChunk));
      if (c.more == 0) return Wait::MyTurn;
      std::uint32_t now = mine;
      if (!c.turn.compare_exchange_strong(now, theirs, std::memory_order_acq_rel)) return Wait::Died;
      wake_all(c.turn);
    }
  }

 private:
  std::size_t width_ = 0;
  ModuleState* states_ = nullptr;
  Channel* channels_ = nullptr;
};

}  // namespace bip::processes
