// See real_time_thread.hpp.
#include "bip/real_time_thread.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>

#include <cerrno>
#include <cstring>

namespace bip::rt {

RealTimeThread::RealTimeThread(bool locks) {
  slack_ns_ = ::prctl(PR_GET_TIMERSLACK, 0, 0, 0, 0);
  if (slack_ns_ > 0) (void)::prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0);
  if (!locks) return;
  is_locked_ = ::mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
  if (!is_locked_) problem_ = std::string("memory is not locked: ") + std::strerror(errno);
}

void RealTimeThread::raise(int priority) {
  sched_param given{};
  int error = ::pthread_getschedparam(::pthread_self(), &policy_, &given);
  before_ = given.sched_priority;
  given.sched_priority = priority;
  if (error == 0) error = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &given);
  is_first_ = error == 0;
  if (!is_first_)
    problem_ += std::string(problem_.empty() ? "" : "; ") + "no real-time priority: " + std::strerror(error);
}

RealTimeThread::~RealTimeThread() {
  if (slack_ns_ > 0) (void)::prctl(PR_SET_TIMERSLACK, static_cast<unsigned long>(slack_ns_), 0, 0, 0);
  if (is_locked_) (void)::munlockall();
  if (!is_first_) return;
  sched_param given{};
  given.sched_priority = before_;
  (void)::pthread_setschedparam(::pthread_self(), policy_, &given);
}

}  // namespace bip::rt
