// Starting a thread that is welcome but not needed.
#pragma once
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace bip::rt {

/// Adds a thread that runs `work`. Returns false if the system has none to give: limits of processes or memory.
template <class Work>
[[nodiscard]] bool start_thread(std::vector<std::thread>& threads, Work&& work) {
  try {
    threads.emplace_back(std::forward<Work>(work));
    return true;
  } catch (const std::system_error&) {
    return false;
  }
}

}  // namespace bip::rt
