// Typed 32-bit ids and the vectors they index.
//
// Every table of the compiler is an `IndexVector<Id, Row>`; an id is only meaningful together with its table.
#pragma once
#include <compare>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "runtime/include/bip/assert.hpp"

namespace bip {

/// A row number with a type, so that an atom's row is never used as a port's.
template <class Tag>
struct Id {
  std::uint32_t value = kNone;
  static constexpr std::uint32_t kNone = 0xffffffffu;

  constexpr Id() = default;
  constexpr explicit Id(std::uint32_t v) : value(v) {}
  constexpr explicit Id(std::size_t v) : value(static_cast<std::uint32_t>(v)) {}
  [[nodiscard]] constexpr bool is_valid() const { return value != kNone; }
  friend constexpr auto operator<=>(Id, Id) = default;
};

/// A vector indexed by `Id` only. Rows keep their place: nothing is ever erased.
template <class IdT, class T>
class IndexVector {
 public:
  IdT push(T row) {
    rows_.push_back(std::move(row));
    return IdT(rows_.size() - 1);
  }
  [[nodiscard]] T& operator[](IdT id) {
    BIP_ASSERT(contains(id), "row {} of {}", id.value, rows_.size());
    return rows_[id.value];
  }
  [[nodiscard]] const T& operator[](IdT id) const {
    BIP_ASSERT(contains(id), "row {} of {}", id.value, rows_.size());
    return rows_[id.value];
  }
  [[nodiscard]] std::size_t size() const { return rows_.size(); }
  [[nodiscard]] bool empty() const { return rows_.empty(); }
  [[nodiscard]] bool contains(IdT id) const { return id.value < rows_.size(); }
  void reserve(std::size_t n) { rows_.reserve(n); }
  [[nodiscard]] std::vector<T>& rows() { return rows_; }
  [[nodiscard]] const std::vector<T>& rows() const { return rows_; }
  auto begin() { return rows_.begin(); }
  auto end() { return rows_.end(); }
  auto begin() const { return rows_.begin(); }
  auto end() const { return rows_.end(); }

 private:
  std::vector<T> rows_;
};

}  // namespace bip

template <class Tag>
struct std::hash<bip::Id<Tag>> {
  std::size_t operator()(bip::Id<Tag> id) const noexcept { return id.value; }
};
