// A bump allocator for trees whose nodes have the same lifetime (the syntax tree).
//
// Only for trivially destructible objects: destructors are not called.
#pragma once
#include <cstdint>
#include <cstring>
#include <memory>
#include <memory_resource>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "runtime/include/bip/assert.hpp"

namespace bip {

class Arena {
 public:
  template <class T>
  T* make(T value) {
    static_assert(std::is_trivially_destructible_v<T>);
    void* to = pool_.allocate(sizeof(T), alignof(T));
    BIP_ASSERT(is_aligned(to, alignof(T)), "the arena gives aligned memory");
    return new (to) T(std::move(value));
  }
  /// Copies `items` into the arena.
  template <class T>
  std::span<const T> list(const std::vector<T>& items) {
    static_assert(std::is_trivially_destructible_v<T>);
    if (items.empty()) return {};
    T* to = static_cast<T*>(pool_.allocate(sizeof(T) * items.size(), alignof(T)));
    BIP_ASSERT(is_aligned(to, alignof(T)), "the arena gives aligned memory");
    std::uninitialized_copy(items.begin(), items.end(), to);
    return {to, items.size()};
  }
  std::string_view text(std::string_view s) {
    if (s.empty()) return {};
    char* to = static_cast<char*>(pool_.allocate(s.size(), 1));
    std::memcpy(to, s.data(), s.size());
    return {to, s.size()};
  }

 private:
  [[nodiscard]] static bool is_aligned(const void* at, std::size_t to) {
    return reinterpret_cast<std::uintptr_t>(at) % to == 0;
  }

  std::pmr::monotonic_buffer_resource pool_{64 * 1024};
};

}  // namespace bip
