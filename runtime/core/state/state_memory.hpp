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

/// The cell of each variable: those of atoms, then the frames of connectors.
class Cells {
 public:
  explicit Cells(std::size_t count) : rows_(count, Cell{0}) {}
  [[nodiscard]] Cell& operator[](VariableId variable) {
    BIP_ASSERT(variable.value < rows_.size(), "variable {} of {}", variable, rows_.size());
    return rows_[variable.value];
  }
  [[nodiscard]] const Cell& operator[](VariableId variable) const {
    BIP_ASSERT(variable.value < rows_.size(), "variable {} of {}", variable, rows_.size());
    return rows_[variable.value];
  }
  [[nodiscard]] std::size_t size() const { return rows_.size(); }
  /// All of them, and those from the variable on, as code wants them.
  [[nodiscard]] Cell* all() { return rows_.data(); }
  [[nodiscard]] const Cell* all() const { return rows_.data(); }
  [[nodiscard]] Cell* from(VariableId first) { return rows_.data() + first.value; }

 private:
  CacheLineVector<Cell> rows_;
};

struct StateMemory {
  explicit StateMemory(const Image& image) : cells(image.cell_count), ffi_data(image) {}

  std::vector<u32> places;  // by atom; of Petri types kNone before the initial state, then 0
  std::vector<u64> marks;   // bitsets of the Petri types' atoms (Tables::first_mark)
  Cells cells;
  FfiData ffi_data;  // the objects behind cells of FFI types
  Binds binds;       // made when code that needs them may run
};

}  // namespace bip::rt
