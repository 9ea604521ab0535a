// See action_pool.hpp.
#include "runtime/core/fire/action_pool.hpp"

#include "bip/assert.hpp"
#include "bip/ffi.hpp"
#include "runtime/core/start_thread.hpp"

namespace bip::rt {

ActionPool::~ActionPool() {
  {
    const std::lock_guard<std::mutex> hold(lock_);
    is_over_ = true;
    waiting_.clear();
  }
  begun_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

std::uint64_t ActionPool::begin(ActionJob job) {
  std::unique_lock<std::mutex> hold(lock_);
  BIP_ASSERT(!is_over_, "the pool has ended");
  waiting_.push_back({++last_, std::move(job)});
  BIP_ASSERT(waiting_.size() < 2 || waiting_[waiting_.size() - 2].number < last_, "job {} is not the last", last_);
  wanted_.insert(last_);
  if (waiting_.size() <= idle_) begun_.notify_one();
  else if (threads_.size() < most_ && !start_thread(threads_, [this] { work(); }) && threads_.empty()) run_first(hold);
  return last_;
}

ActionJob ActionPool::take(std::uint64_t job) {
  std::unique_lock<std::mutex> hold(lock_);
  BIP_ASSERT(wanted_.contains(job), "job {} was dropped or taken", job);
  done_.wait(hold, [&] { return ended_.contains(job); });
  ActionJob out = std::move(ended_.extract(job).mapped());
  wanted_.erase(job);
  return out;
}

void ActionPool::drop() {
  const std::lock_guard<std::mutex> hold(lock_);
  waiting_.clear();
  wanted_.clear();
  ended_.clear();
}

void ActionPool::work() {
  std::unique_lock<std::mutex> hold(lock_);
  while (true) {
    ++idle_;
    begun_.wait(hold, [this] { return is_over_ || !waiting_.empty(); });
    --idle_;
    if (is_over_) return;
    BIP_ASSERT(idle_ <= threads_.size(), "{} of {} threads are idle", idle_, threads_.size());
    run_first(hold);
  }
}

void ActionPool::run_first(std::unique_lock<std::mutex>& hold) {
  BIP_ASSERT(hold.owns_lock() && !waiting_.empty(), "no job waits");
  Numbered next = std::move(waiting_.front());
  waiting_.pop_front();
  hold.unlock();
  ActionJob& job = next.job;
  // Without an action there is nothing to wait for.
  job.status = job.action.fn == nullptr ? 1 : job.action.fn(job.action.context, job.self.data(), nullptr, nullptr);
  // Each thread sees the exception of its own last call.
  if (job.status >= 2 && job.ffi != nullptr) job.message = job.ffi->message();
  const std::uint32_t atom = job.atom;
  hold.lock();
  if (!wanted_.contains(next.number)) return;
  ended_.emplace(next.number, std::move(job));
  done_.notify_all();
  hold.unlock();
  on_done_(atom, next.number);
  hold.lock();
}

}  // namespace bip::rt
