// An object that all modules of a robot see, also if their codels run in processes of their own (codel_processes.hpp):
// a simulated world, a device's registers. Header only.
#pragma once
#include <pthread.h>
#include <sys/mman.h>

#include <cerrno>
#include <memory>
#include <type_traits>

namespace bip {

/// Owns a T in memory that processes share which are forked later. Make it a static object. T holds no pointers to
/// memory of its own; who writes while others read uses
/// atomics, or a SharedMutex in T. Without memory `get()` is null.
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

/// A lock within a SharedObject, of all threads of all processes, for std::lock_guard; who holds it may take it again.
/// If the process of its holder dies, the next one gets it, with what the object holds then.
class SharedMutex {
 public:
  SharedMutex() {
    pthread_mutexattr_t kind;
    (void)::pthread_mutexattr_init(&kind);
    (void)::pthread_mutexattr_setpshared(&kind, PTHREAD_PROCESS_SHARED);
    (void)::pthread_mutexattr_setrobust(&kind, PTHREAD_MUTEX_ROBUST);
    (void)::pthread_mutexattr_settype(&kind, PTHREAD_MUTEX_RECURSIVE);
    (void)::pthread_mutex_init(&mutex_, &kind);
    (void)::pthread_mutexattr_destroy(&kind);
  }
  SharedMutex(const SharedMutex&) = delete;
  SharedMutex& operator=(const SharedMutex&) = delete;
  void lock() {
    if (::pthread_mutex_lock(&mutex_) == EOWNERDEAD) (void)::pthread_mutex_consistent(&mutex_);
  }
  void unlock() { (void)::pthread_mutex_unlock(&mutex_); }

 private:
  pthread_mutex_t mutex_;
};

}  // namespace bip
