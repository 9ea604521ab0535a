// Objects that hold the result of a call with an FFI type until it is used: one per call and thread.
//
// Calls do not nest in themselves, but with `--engine=threads` two atoms of a type can execute the same call at the
// same time. An object is created at the first call of a thread and reused; each access takes one lock (as FfiState
// does for strings).
#pragma once
#include <cstdint>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "runtime/include/bip/ffi.hpp"

namespace bip::lower {

class Results {
 public:
  Results() = default;
  Results(const Results&) = delete;
  Results& operator=(const Results&) = delete;
  ~Results() { clear(); }

  /// The variable whose object holds what call `row` (an ExprId) gives the calling thread. Stays where it is until
  /// clear().
  [[nodiscard]] rt::Cell* cell(std::uint32_t row, const rt::FfiType& type) {
    const std::lock_guard guard(lock_);
    const auto [it, is_new] = objects_.try_emplace({std::this_thread::get_id(), row});
    if (is_new) it->second = {rt::object_cell(type.make()), type.destroy};
    return &it->second.cell;
  }
  /// Destroys all objects. Before the C++ code of their types is unloaded.
  void clear() {
    for (const auto& [key, object] : objects_) object.destroy(&rt::object_in<char>(object.cell));
    objects_.clear();
  }

 private:
  struct Object {
    rt::Cell cell{};
    void (*destroy)(void*) = nullptr;
  };
  std::map<std::pair<std::thread::id, std::uint32_t>, Object> objects_;
  std::mutex lock_;
};

}  // namespace bip::lower
