// A set of rows that must be looked at again, each listed once, in the order in which they were marked.
#pragma once
#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "bip/assert.hpp"
#include "bip/ids.hpp"
#include "runtime/core/state/row_list.hpp"

namespace bip::rt {

/// Row: an id, or a plain row number.
template <class Row>
class DirtyRows {
 public:
  /// Empties the set; rows below `size` may be marked from now on.
  void reset(std::size_t size) {
    rows_.clear();
    held_.clear();
    is_in_.assign(size, 0);
  }
  [[nodiscard]] bool empty() const { return rows_.empty(); }
  // The marked rows, in the order in which they were marked.
  [[nodiscard]] auto begin() const { return rows_.begin(); }
  [[nodiscard]] auto end() const { return rows_.end(); }
  [[nodiscard]] bool has(Row row) const { return is_in_[number_of(row)] != 0; }
  /// Adds the row unless it is in. O(1).
  void mark(Row row) {
    BIP_ASSERT(number_of(row) < is_in_.size(), "row {} of {}", row, is_in_.size());
    if (is_in_[number_of(row)] != 0) return;
    is_in_[number_of(row)] = 1;
    rows_.push(row);
  }
  void clear() {
    BIP_ASSERT(std::all_of(rows_.begin(), rows_.end(), [this](Row row) { return has(row); }),
               "a row of the list is not in the set");
    for (const Row row : rows_) is_in_[number_of(row)] = 0;
    rows_.clear();
  }
  /// Takes the rows for which `is_held` out of the range; they stay in the set. O(rows).
  template <class Predicate>
  void hold(const Predicate& is_held) {
    BIP_ASSERT(held_.empty(), "{} rows are held already", held_.size());
    Row* const end = std::stable_partition(rows_.begin(), rows_.end(), [&](Row row) { return !is_held(row); });
    held_.clear();
    for (const Row* row = end; row != rows_.end(); ++row) held_.push(*row);
    rows_.shorten(static_cast<std::size_t>(end - rows_.begin()));
  }
  /// Lets the held rows take the place of those that were looked at.
  void release() {
    BIP_ASSERT(std::all_of(held_.begin(), held_.end(), [this](Row row) { return has(row); }), "a held row left");
    std::swap(rows_, held_);
    held_.clear();
  }
  [[nodiscard]] std::size_t bytes() const { return is_in_.size(); }

 private:
  RowList<Row> rows_;
  RowList<Row> held_;
  std::vector<std::uint8_t> is_in_;  // by row
};

}  // namespace bip::rt
