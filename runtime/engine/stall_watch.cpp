// See stall_watch.hpp.
#include "runtime/engine/stall_watch.hpp"

#include <chrono>
#include <cstdio>
#include <utility>

#include "bip/assert.hpp"
#include "runtime/core/start_thread.hpp"
#include "runtime/core/time/time_text.hpp"
#include "runtime/engine/waker.hpp"

namespace bip::rt {

namespace {

// To a millisecond, of a second and more to a tenth of a second.
std::string rounded_time(i64 ns) {
  const i64 unit = ns < 1'000'000'000 ? 1'000'000 : 100'000'000;
  std::string text;
  append_time(text, ns / unit * unit);
  return text;
}

}  // namespace

StallWatch::StallWatch(const StallOptions& options, std::string node) : options_(options), node_(std::move(node)) {
  BIP_ASSERT(options.after > 0, "a watch without a bound");
}

StallWatch::~StallWatch() {
  if (threads_.empty()) return;
  {
    const std::lock_guard<std::mutex> hold(lock_);
    is_over_ = true;
  }
  ended_.notify_all();
  for (std::thread& thread : threads_) thread.join();
  if (options_.stop != nullptr) options_.stop("the run has ended");
}

bool StallWatch::start() {
  note_steps();
  return start_thread(threads_, [this] { watch(); });
}

void StallWatch::note_steps() { last_.store(wall_clock(), std::memory_order_relaxed); }

void StallWatch::watch() {
  const std::chrono::nanoseconds look(options_.after / 8 + 1);
  i64 stopped = 0;  // the last steps before the node stood still; 0: it does not
  std::unique_lock<std::mutex> hold(lock_);
  while (!ended_.wait_for(hold, look, [this] { return is_over_; })) {
    const i64 last = last_.load(std::memory_order_relaxed), now = wall_clock();
    if (stopped != 0 && last != stopped) {
      const std::string why = "steps end again after " + rounded_time(last - stopped);
      stopped = 0;
      if (options_.go_on != nullptr) options_.go_on(why.c_str());
      tell(why);
    } else if (stopped == 0 && now - last >= options_.after) {
      const std::string why = "no step has ended for " + rounded_time(now - last);
      stopped = last;
      if (options_.stop != nullptr) {
        options_.stop(why.c_str());
        tell(why + ": `" + options_.stop_name + "` was called");
      } else {
        tell(why);
      }
    }
  }
}

void StallWatch::tell(const std::string& text) const {
  std::fprintf(stderr, "bipc: node `%s`: %s\n", node_.c_str(), text.c_str());
  std::fflush(stderr);
}

}  // namespace bip::rt
