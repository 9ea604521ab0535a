// Rows in the order in which they came, for lists that are filled and emptied in each step. There is always room for
// one more, so that code that adds a row does nothing after a call: what adds one mostly needs no frame of its own.
#pragma once
#include <cstddef>
#include <vector>

#include "bip/assert.hpp"

namespace bip::rt {

template <class Row>
class RowList {
 public:
  void push(Row row) {
    rows_[size_] = row;
    if (++size_ == rows_.size()) grow();
  }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] Row* begin() { return rows_.data(); }
  [[nodiscard]] Row* end() { return rows_.data() + size_; }
  [[nodiscard]] const Row* begin() const { return rows_.data(); }
  [[nodiscard]] const Row* end() const { return rows_.data() + size_; }
  /// Keeps the first `size` rows.
  void shorten(std::size_t size) {
    BIP_ASSERT(size <= size_, "{} rows of {}", size, size_);
    size_ = size;
  }
  void clear() { size_ = 0; }

 private:
  static constexpr std::size_t kFirst = 16;
  [[gnu::noinline, gnu::cold]] void grow() { rows_.resize(rows_.size() * 2); }

  std::vector<Row> rows_ = std::vector<Row>(kFirst);
  std::size_t size_ = 0;
};

}  // namespace bip::rt
