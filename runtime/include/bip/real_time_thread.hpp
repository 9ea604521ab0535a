// How the system treats the thread of a run in real time: exact timers, and if asked for, before others and never
// swapped out.
//
// Only the thread that makes one; but threads that it starts inherit its priority, so it is raised when they are there.
// Locking memory takes its time (a tenth of a second with libLLVM), so that is done first. What the system refuses is
// told, and the run goes on without.
#pragma once
#include <string>

namespace bip::rt {

class RealTimeThread {
 public:
  /// Timers of this thread are no longer put off to be met together (Linux: by 50 us). locks: the process's memory
  /// stays where it is.
  explicit RealTimeThread(bool locks);
  /// To a priority of SCHED_FIFO, 1 to 99.
  void raise(int priority);
  /// What was refused, and why; else empty.
  [[nodiscard]] const std::string& problem() const { return problem_; }
  /// As it was. The same thread.
  ~RealTimeThread();
  RealTimeThread(const RealTimeThread&) = delete;
  RealTimeThread& operator=(const RealTimeThread&) = delete;

 private:
  std::string problem_;
  int slack_ns_ = -1;
  int policy_ = 0, before_ = 0;
  bool is_first_ = false, is_locked_ = false;
};

}  // namespace bip::rt
