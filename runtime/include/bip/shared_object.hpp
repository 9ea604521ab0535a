// An object that all modules of a robot see, also if their codels run in processes of their own (codel_processes.hpp):
// a simulated world, a device's registers. Header only.
#pragma once
#include <sys/mman.h>

#include <memory>
#include <type_traits>

namespace bip {

/// Owns a T in memory that processes share which are forked later. Make it a static object. T holds no pointers to
/// memory of its own; who writes while others read uses atomics. Without memory `get()` is null.
template <class T>
class SharedObject {
  static_assert(std::is_trivially_destructible_v<T>, "what is shared owns nothing");

 public:
  SharedObject() {
    void* const place =
        ::mmap(nullptr, sizeof(T), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (place != MAP_FAILED) object_ = std::construct_at(static_cast<T*>(place));
  }
  ~SharedObject() {
    if (object_ != nullptr) ::munmap(object_, sizeof(T));
  }
  SharedObject(const SharedObject&) = delete;
  SharedObject& operator=(const SharedObject&) = delete;
  [[nodiscard]] T* get() const { return object_; }
  T& operator*() const { return *object_; }
  T* operator->() const { return object_; }

 private:
  T* object_ = nullptr;
};

}  // namespace bip
