// The storage of a state: markings, cells of data, objects of FFI types. Plain data that the parts of a core share;
// what it means is theirs (atom_steps.hpp, firing.hpp).
#pragma once
#include <cstddef>
#include <new>
#include <vector>

#include "runtime/core/link/tables.hpp"
#include "runtime/core/state/ffi_data.hpp"

namespace bip::rt {

/// Memory from the start of a cache line on: a vector of a loop over it touches one line, not two.
template <class T>
struct InCacheLines {
  using value_type = T;
  static constexpr std::align_val_t kAlign{64};
  InCacheLines() = default;
  template <class U>
  InCacheLines(const InCacheLines<U>&) {}
  T* allocate(std::size_t count) { return static_cast<T*>(::operator new(count * sizeof(T), kAlign)); }
  void deallocate(T* memory, std::size_t) { ::operator delete(memory, kAlign); }
  friend bool operator==(const InCacheLines&, const InCacheLines&) { return true; }
};

template <class T>
using CacheLineVector = std::vector<T, InCacheLines<T>>;

struct StateMemory {
  explicit StateMemory(const Image& image) : cells(image.cell_count, Cell{0}), ffi_data(image) {}

  std::vector<u32> places;      // by atom; of Petri types kNone before the initial state, then 0
  std::vector<u64> marks;       // bitsets of the Petri types' atoms (Tables::first_mark)
  CacheLineVector<Cell> cells;  // atoms' variables, then the frames of connectors
  FfiData ffi_data;             // the objects behind cells of FFI types
  Binds binds;                  // made when code that needs them may run
};

}  // namespace bip::rt
