// A thread beside a node of a run on several hosts that calls a function of the model's C++ when the node stands still:
// no step of it has ended for some time, whatever the reason is (an action that hangs, a cable that is out, a node that
// is lost). A second function is called when steps end again, and the first one once more when the run is over. Both
// changes are reported on standard error, also if the model's C++ has no such functions.
//
// It shares an instant with the node and nothing else, so that no lock that a hanging action holds can hold it up. It
// looks eight times within the bound. Cost: a store for each action that ends.
#pragma once
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "runtime/core/time/interval.hpp"
#include "runtime/distributed/deployment.hpp"

namespace bip::rt {

class StallWatch {
 public:
  /// `node`: its name, for messages. The options must outlive the watch.
  StallWatch(const StallOptions& options, std::string node);
  /// Ends as the run does: calls `stop`.
  ~StallWatch();
  StallWatch(const StallWatch&) = delete;
  StallWatch& operator=(const StallWatch&) = delete;

  /// Begins. Returns false if the system has no thread to give.
  [[nodiscard]] bool start();
  /// The node's thread: steps have ended.
  void note_steps();

 private:
  void watch();
  void tell(const std::string& text) const;

  const StallOptions& options_;
  std::string node_;
  std::atomic<i64> last_{0};  // ns of the wall clock
  std::mutex lock_;
  std::condition_variable ended_;
  bool is_over_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace bip::rt
