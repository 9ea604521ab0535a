// A fixed team of threads that works in phases: run(job) calls job(0) … job(n-1), each on its own thread, and returns
// when all are done. Jobs do not wait for each other. Everything that happened before run is seen by the jobs, and what
// they did by the caller of run.
//
// Where the system has fewer threads to give, the caller does the jobs of those that are missing. A phase costs two
// wake-ups, some 10 µs: for work of less than that, call the jobs one after the other.
#pragma once
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "runtime/core/start_thread.hpp"

namespace bip::rt {

class Team {
 public:
  explicit Team(std::uint32_t threads) : size_(threads) {
    for (std::uint32_t k = 1; k < threads; ++k) {
      if (!start_thread(threads_, [this, k] { work(k); })) break;
    }
  }
  ~Team() {
    {
      const std::lock_guard guard(lock_);
      is_over_ = true;
    }
    wake_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  [[nodiscard]] std::uint32_t size() const { return size_; }
  void run(const std::function<void(std::uint32_t)>& job) {
    const auto helpers = static_cast<std::uint32_t>(threads_.size());
    if (helpers == 0) return run_alone(job, 0);
    {
      const std::lock_guard guard(lock_);
      job_ = &job;
      ++phase_;
      busy_ = helpers;
    }
    wake_.notify_all();
    job(0);
    run_alone(job, helpers + 1);
    std::unique_lock guard(lock_);
    done_.wait(guard, [this] { return busy_ == 0; });
  }

 private:
  void run_alone(const std::function<void(std::uint32_t)>& job, std::uint32_t first) const {
    for (std::uint32_t k = first; k < size_; ++k) job(k);
  }
  void work(std::uint32_t k) {
    std::uint64_t seen = 0;
    std::unique_lock guard(lock_);
    for (;;) {
      wake_.wait(guard, [&] { return is_over_ || phase_ != seen; });
      if (is_over_) return;
      seen = phase_;
      const std::function<void(std::uint32_t)>& job = *job_;
      guard.unlock();
      job(k);
      guard.lock();
      if (--busy_ == 0) done_.notify_one();
    }
  }

  std::uint32_t size_;
  std::vector<std::thread> threads_;
  std::mutex lock_;
  std::condition_variable wake_, done_;
  const std::function<void(std::uint32_t)>* job_ = nullptr;
  std::uint64_t phase_ = 0;
  std::uint32_t busy_ = 0;
  bool is_over_ = false;
};

}  // namespace bip::rt
