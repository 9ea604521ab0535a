// A codel that takes as long as it is told, awake: what --engine=threads is for.
#pragma once
#include <chrono>

/// Returns n + 1 after so many microseconds.
inline int busy(int n, int microseconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(microseconds);
  while (std::chrono::steady_clock::now() < end) {
  }
  return n + 1;
}
