// Typed 32-bit ids and the vectors they index, of the compiler's tables and of the runtime's.
//
// An id is a row number with a type: it is only meaningful together with its table, and ids of two kinds do not convert
// into each other or into numbers. An id is as large as its number and is passed like it.
#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include "assert.hpp"  // beside this file: the compiler has no other path to it

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

/// The number of a row, typed or not.
[[nodiscard]] constexpr std::uint32_t number_of(std::uint32_t row) { return row; }
template <class Tag>
[[nodiscard]] constexpr std::uint32_t number_of(Id<Tag> row) {
  return row.value;
}

/// The ids [first, end), in order.
template <class IdT>
class IdRange {
 public:
  class Iterator {
   public:
    constexpr explicit Iterator(std::uint32_t at) : at_(at) {}
    constexpr IdT operator*() const { return IdT(at_); }
    constexpr Iterator& operator++() {
      ++at_;
      return *this;
    }
    friend constexpr bool operator==(Iterator, Iterator) = default;

   private:
    std::uint32_t at_;
  };

  /// All ids below `count`.
  constexpr explicit IdRange(std::size_t count) : IdRange(0, count) {}
  constexpr IdRange(std::size_t first, std::size_t end)
      : first_(static_cast<std::uint32_t>(first)), end_(static_cast<std::uint32_t>(end)) {}
  [[nodiscard]] constexpr Iterator begin() const { return Iterator(first_); }
  [[nodiscard]] constexpr Iterator end() const { return Iterator(end_); }

 private:
  std::uint32_t first_, end_;
};

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

namespace bip::rt {

/// An interaction: a row of Tables::interactions, the canonical order of candidates.
using InteractionId = Id<struct InteractionTag>;
/// A variable of the system, of an atom or of a connector: a row of all cells.
using VariableId = Id<struct VariableTag>;
/// The k-th variable of those that stand from `first` on: an atom's, or a connector's own.
[[nodiscard]] constexpr VariableId operator+(VariableId first, std::uint32_t k) { return VariableId(first.value + k); }
/// Which one of those from `first` on it is.
[[nodiscard]] constexpr std::uint32_t operator-(VariableId variable, VariableId first) {
  return variable.value - first.value;
}
static_assert(sizeof(InteractionId) == 4 && std::is_trivially_copyable_v<InteractionId>);
static_assert(sizeof(VariableId) == 4 && std::is_trivially_copyable_v<VariableId>);

}  // namespace bip::rt

template <class Tag>
struct std::hash<bip::Id<Tag>> {
  std::size_t operator()(bip::Id<Tag> id) const noexcept { return id.value; }
};
