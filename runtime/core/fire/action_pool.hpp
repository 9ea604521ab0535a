// Threads for actions that run beside the others (`@async`): an action works on a copy of its atom's data, so nothing
// is shared with the model, which goes on. Jobs begin in their order; a thread is made when all others are at work, up
// to a bound.
//
// One thread begins and takes jobs, the pool's threads run them; on_done is called on those. A job that is dropped runs
// to its end unseen, for a C++ function cannot be stopped. Cost: a lock and a wake-up a job.
#pragma once
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "runtime/core/state/ffi_data.hpp"

namespace bip::rt {

struct ActionJob {
  std::uint32_t atom = kNone;
  Code action;
  std::vector<Cell> self;         // of the atom; cells of FFI types name `objects`
  std::vector<FfiValue> objects;  // in the order of their cells
  FfiContext* ffi = nullptr;
  std::int32_t status = 0;  // afterwards
  std::string message;      // of the exception, if it ended so
};

class ActionPool {
 public:
  /// on_done(atom, job): a job of the atom has ended.
  ActionPool(std::uint32_t most_threads, std::function<void(std::uint32_t, std::uint64_t)> on_done)
      : most_(most_threads), on_done_(std::move(on_done)) {}
  ActionPool(const ActionPool&) = delete;
  ActionPool& operator=(const ActionPool&) = delete;
  /// Waits for the jobs that run.
  ~ActionPool();

  /// The job's number, from 1 on.
  std::uint64_t begin(ActionJob job);
  /// The job as it ended; waits for that. Once.
  [[nodiscard]] ActionJob take(std::uint64_t job);
  /// Forgets the jobs begun so far: none of them will be taken.
  void drop();

 private:
  struct Numbered {
    std::uint64_t number;
    ActionJob job;
  };
  void work();
  /// Runs the first job that waits; unlocked meanwhile.
  void run_first(std::unique_lock<std::mutex>& hold);

  std::uint32_t most_;
  std::function<void(std::uint32_t, std::uint64_t)> on_done_;
  std::mutex lock_;
  std::condition_variable begun_, done_;
  std::deque<Numbered> waiting_;
  std::map<std::uint64_t, ActionJob> ended_;
  std::set<std::uint64_t> wanted_;
  std::vector<std::thread> threads_;
  std::uint64_t last_ = 0;
  std::size_t idle_ = 0;
  bool is_over_ = false;
};

}  // namespace bip::rt
