// Typed 32-bit ids, of the compiler's tables and of the runtime's. Emitted programs read this header: it stays small.
//
// An id is a row number with a type: it is only meaningful together with its table, and ids of two kinds do not convert
// into each other or into numbers. An id is as large as its number and is passed like it.
#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>
#include <type_traits>

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
