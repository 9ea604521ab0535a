// Better code for a running image: another thread makes it, the engine takes it between two steps. The
// run's steps are the same; only how long they take changes.
#pragma once
#include <atomic>
#include <functional>
#include <vector>

#include "bip/image.hpp"

namespace bip::rt {

struct NewCode {
  std::atomic<bool> is_ready{false};
  /// On the engine's thread, once is_ready: puts the code into the image. The rows of code that were there.
  std::function<std::vector<Code>()> install;
};

}  // namespace bip::rt
