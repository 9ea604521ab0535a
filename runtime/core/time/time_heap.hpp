// What happens next: a key (an instant) for each of n rows, and the row with the smallest one; of equal keys the
// smaller row.
//
// A tournament (Knuth, The Art of Computer Programming 3, 5.4.1): a complete tree whose leaves are the rows, each node
// the row that wins below it. A new key walks from its leaf to the root, without branches that depend on keys, and
// stops where the winner is as before and another entry: O(log n), and O(1) for most keys that are later than others.
// A heap does a third more comparisons to take its first out.
#pragma once
#include <bit>
#include <vector>

#include "bip/assert.hpp"
#include "runtime/core/time/interval.hpp"

namespace bip::rt {

class TimeHeap {
 public:
  /// All keys kForever.
  void reset(std::size_t rows) {
    leaves_ = static_cast<std::uint32_t>(std::bit_ceil(rows + (rows == 0 ? 1 : 0)));
    BIP_ASSERT(std::has_single_bit(leaves_) && leaves_ >= rows, "{} leaves of {} rows", leaves_, rows);
    keys_.assign(leaves_, kForever);
    winners_.assign(std::size_t{2} * leaves_, 0);
    for (std::uint32_t row = 0; row < leaves_; ++row) winners_[leaves_ + row] = row;
    for (std::uint32_t node = leaves_ - 1; node > 0; --node) winners_[node] = winners_[2 * node];
  }
  /// Is every key kForever?
  [[nodiscard]] bool empty() const { return first_key() == kForever; }
  [[nodiscard]] i64 first_key() const { return keys_[winners_[1]]; }
  [[nodiscard]] std::uint32_t first_row() const { return winners_[1]; }
  [[nodiscard]] i64 key(std::uint32_t row) const { return keys_[row]; }
  /// Of all rows.
  [[nodiscard]] std::size_t bytes() const {
    return keys_.size() * sizeof(i64) + winners_.size() * sizeof(std::uint32_t);
  }

  void set(std::uint32_t row, i64 key) {
    BIP_ASSERT(row < leaves_, "row {} of {}", row, leaves_);
    if (keys_[row] == key) return;
    keys_[row] = key;
    for (std::uint32_t node = (leaves_ + row) / 2; node != 0; node /= 2) {
      const std::uint32_t left = winners_[2 * node], right = winners_[2 * node + 1];
      const std::uint32_t winner = keys_[right] < keys_[left] ? right : left;
      if (winner != row && winner == winners_[node]) return;
      winners_[node] = winner;
    }
  }

  /// Does each node hold the winner of the two below it? O(rows).
  [[nodiscard]] bool is_consistent() const {
    for (std::uint32_t node = leaves_ - 1; node > 0; --node) {
      const std::uint32_t left = winners_[2 * node], right = winners_[2 * node + 1];
      if (winners_[node] != (keys_[right] < keys_[left] ? right : left)) return false;
    }
    return true;
  }

 private:
  std::uint32_t leaves_ = 1;                  // a power of two
  std::vector<i64> keys_{kForever};           // by row
  std::vector<std::uint32_t> winners_{0, 0};  // by node; node k is above 2k and 2k + 1, the leaves begin at leaves_
};

}  // namespace bip::rt
