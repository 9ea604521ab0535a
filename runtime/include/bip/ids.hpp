// Vectors that typed ids (id.hpp) index, and the ids' hash.
#pragma once
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "assert.hpp"  // beside this file: the compiler has no other path to it
#include "id.hpp"

namespace bip {

/// A vector indexed by `Id` only. Rows keep their place: nothing is ever erased.
template <class IdT, class T>
class IndexVector {
 public:
  IndexVector() = default;
  explicit IndexVector(std::size_t size, const T& row = T()) : rows_(size, row) {}

  IdT push(T row) {
    rows_.push_back(std::move(row));
    return IdT(rows_.size() - 1);
  }
  [[nodiscard]] decltype(auto) operator[](IdT id) {
    BIP_ASSERT(contains(id), "row {} of {}", id.value, rows_.size());
    return rows_[id.value];
  }
  [[nodiscard]] decltype(auto) operator[](IdT id) const {
    BIP_ASSERT(contains(id), "row {} of {}", id.value, rows_.size());
    return rows_[id.value];
  }
  [[nodiscard]] std::size_t size() const { return rows_.size(); }
  [[nodiscard]] bool empty() const { return rows_.empty(); }
  [[nodiscard]] bool contains(IdT id) const { return id.value < rows_.size(); }
  [[nodiscard]] IdRange<IdT> ids() const { return IdRange<IdT>(rows_.size()); }
  void reserve(std::size_t n) { rows_.reserve(n); }
  /// Gives the vector `size` rows, each equal to `row`.
  void assign(std::size_t size, const T& row) { rows_.assign(size, row); }
  [[nodiscard]] std::vector<T>& rows() { return rows_; }
  [[nodiscard]] const std::vector<T>& rows() const { return rows_; }
  auto begin() { return rows_.begin(); }
  auto end() { return rows_.end(); }
  auto begin() const { return rows_.begin(); }
  auto end() const { return rows_.end(); }
  friend bool operator==(const IndexVector&, const IndexVector&) = default;

 private:
  std::vector<T> rows_;
};

}  // namespace bip

template <class Tag>
struct std::hash<bip::Id<Tag>> {
  std::size_t operator()(bip::Id<Tag> id) const noexcept { return id.value; }
};
