// What happens next: a key (an instant) for each of n rows, and the row with the smallest one. A binary heap that knows where
// each row is, so that a new key costs O(log n); rows whose key is kForever are not in it. Equal keys: the smaller row first.
#pragma once
#include <utility>
#include <vector>

#include "runtime/core/interval.hpp"

namespace bip::rt {

class TimeHeap {
 public:
  void reset(std::size_t rows) {
    keys_.assign(rows, kForever);
    places_.assign(rows, kNone);
    heap_.clear();
  }
  [[nodiscard]] bool empty() const { return heap_.empty(); }
  /// kForever if there is none.
  [[nodiscard]] i64 first_key() const { return heap_.empty() ? kForever : keys_[heap_.front()]; }
  [[nodiscard]] std::uint32_t first_row() const { return heap_.front(); }
  [[nodiscard]] i64 key(std::uint32_t row) const { return keys_[row]; }

  void set(std::uint32_t row, i64 key) {
    const i64 before = keys_[row];
    if (before == key) return;
    keys_[row] = key;
    if (before == kForever) {
      places_[row] = static_cast<std::uint32_t>(heap_.size());
      heap_.push_back(row);
      rise(places_[row]);
    } else if (key == kForever) {
      const std::uint32_t hole = places_[row];
      places_[row] = kNone;
      const std::uint32_t last = heap_.back();
      heap_.pop_back();
      if (last == row) return;
      put(hole, last);
      rise(hole);
      sink(places_[last]);
    } else if (key < before) {
      rise(places_[row]);
    } else {
      sink(places_[row]);
    }
  }

 private:
  [[nodiscard]] bool is_before(std::uint32_t a, std::uint32_t b) const { return keys_[a] != keys_[b] ? keys_[a] < keys_[b] : a < b; }
  void put(std::uint32_t place, std::uint32_t row) {
    heap_[place] = row;
    places_[row] = place;
  }
  void rise(std::uint32_t place) {
    const std::uint32_t row = heap_[place];
    for (; place != 0 && is_before(row, heap_[(place - 1) / 2]); place = (place - 1) / 2) put(place, heap_[(place - 1) / 2]);
    put(place, row);
  }
  void sink(std::uint32_t place) {
    const std::uint32_t row = heap_[place];
    const auto size = static_cast<std::uint32_t>(heap_.size());
    for (std::uint32_t child = 2 * place + 1; child < size; child = 2 * place + 1) {
      if (child + 1 < size && is_before(heap_[child + 1], heap_[child])) ++child;
      if (!is_before(heap_[child], row)) break;
      put(place, heap_[child]);
      place = child;
    }
    put(place, row);
  }

  std::vector<i64> keys_;               // by row
  std::vector<std::uint32_t> places_;   // by row, in heap_
  std::vector<std::uint32_t> heap_;
};

}  // namespace bip::rt
