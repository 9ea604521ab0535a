// What the parts of a search hold, so that its limit of memory is that of the process.
#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

namespace bip::rt {

/// What the allocator takes for so many bytes: of glibc a word more, in units of two words, at least four.
[[nodiscard]] constexpr std::size_t allocated(std::size_t bytes) {
  constexpr std::size_t kWord = sizeof(void*);
  return bytes == 0 ? 0 : std::max(4 * kWord, (bytes + kWord + 2 * kWord - 1) / (2 * kWord) * (2 * kWord));
}

/// Without what its elements hold.
template <class T>
[[nodiscard]] std::size_t heap_bytes(const std::vector<T>& values) {
  return allocated(values.capacity() * sizeof(T));
}

}  // namespace bip::rt
