// How tables stand in an image: spans of rows; and of instances, rows that follow from those before.
//
// Arrays of components and connectors are stored once: rows whose numbers grow evenly are a first one and a slope, so a
// model of 100,000 equal parts takes a page, names and places included. A row is returned by value: O(log
// repeats), a load without any.
#pragma once
#include <cstddef>
#include <cstdint>

#include "bip/contract.hpp"

namespace bip::rt {

inline constexpr std::uint32_t kNone = 0xffffffffu;  // no row, no code

template <class T>
struct Span {
  const T* data = nullptr;
  std::uint32_t size = 0;
  const T& operator[](std::size_t i) const {
    BIP_ASSERT(i < size, "element {} of {}", i, size);
    return data[i];
  }
  const T* begin() const { return data; }
  const T* end() const { return data + size; }
};

/// From row `first` on, until the next one's: `period` rows again and again, each time further by their slopes.
struct Repeat {
  std::uint32_t first;
  std::uint32_t period;
  std::uint32_t row;    // where they stand
  std::uint32_t slope;  // of the first of them; kNone: they come once, as they stand
};

/// A table of T, which has a T::Slope and T::after(slope, times).
template <class T>
struct Rows {
  using Slope = typename T::Slope;
  Span<T> rows;
  Span<Repeat> repeats;  // empty: all rows are as they stand
  Span<Slope> slopes;
  std::uint32_t size = 0;

  constexpr Rows() = default;
  constexpr Rows(Span<T> all) : rows(all), size(all.size) {}
  constexpr Rows(const T* data, std::uint32_t count) : Rows(Span<T>{data, count}) {}
  constexpr Rows(Span<T> stand, Span<Repeat> all, Span<Slope> by, std::uint32_t count)
      : rows(stand), repeats(all), slopes(by), size(count) {}

  T operator[](std::size_t i) const {
    if (repeats.size == 0) return rows[i];
    BIP_ASSERT(i < size && repeats[0].first == 0, "row {} of {}", i, size);
    const auto row = static_cast<std::uint32_t>(i);
    // The last one that begins at the row or before it. By hand: <algorithm> is no header for emitted programs.
    std::uint32_t at = 0;
    for (std::uint32_t end = repeats.size; end - at > 1;) {
      const std::uint32_t middle = at + (end - at) / 2;
      if (repeats.data[middle].first <= row) at = middle;
      else end = middle;
    }
    const Repeat& repeat = repeats.data[at];
    const std::uint32_t offset = row - repeat.first;
    BIP_ASSERT(repeat.period != 0 || repeat.slope == kNone, "rows of no period from {} on", repeat.first);
    if (repeat.slope == kNone) return rows[repeat.row + offset];
    const std::uint32_t times = offset / repeat.period, which = offset % repeat.period;
    return rows[repeat.row + which].after(slopes[repeat.slope + which], times);
  }

  class Iterator {
   public:
    Iterator(const Rows& table, std::uint32_t row) : table_(&table), row_(row) {}
    T operator*() const { return (*table_)[row_]; }
    Iterator& operator++() {
      ++row_;
      return *this;
    }
    bool operator!=(const Iterator& other) const { return row_ != other.row_; }

   private:
    const Rows* table_;
    std::uint32_t row_;
  };
  Iterator begin() const { return {*this, 0}; }
  Iterator end() const { return {*this, size}; }
};

}  // namespace bip::rt
