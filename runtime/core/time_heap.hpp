// What happens next: a key (an instant) for each of n rows, and the row with the smallest one. A heap that knows where each row
// is, so that a new key costs O(log n); rows whose key is kForever are not in it. Equal keys: the smaller row first. Each entry
// has four below it, and keys lie in the entries: half the levels of a binary heap, and a level is a cache line or two.
#pragma once
#include <algorithm>
#include <vector>

#include "runtime/core/interval.hpp"

namespace bip::rt {

class TimeHeap {
 public:
  void reset(std::size_t rows) {
    places_.assign(rows, kNone);
    heap_.clear();
  }
  [[nodiscard]] bool empty() const { return heap_.empty(); }
  /// kForever if there is none.
  [[nodiscard]] i64 first_key() const { return heap_.empty() ? kForever : heap_.front().key; }
  [[nodiscard]] std::uint32_t first_row() const { return heap_.front().row; }
  [[nodiscard]] i64 key(std::uint32_t row) const { return places_[row] == kNone ? kForever : heap_[places_[row]].key; }

  void set(std::uint32_t row, i64 key) {
    const std::uint32_t place = places_[row];
    if (place == kNone) {
      if (key == kForever) return;
      heap_.push_back({key, row});
      rise(static_cast<std::uint32_t>(heap_.size()) - 1, {key, row});
    } else if (key == kForever) {
      const Entry last = heap_.back();
      heap_.pop_back();
      places_[row] = kNone;
      if (last.row != row) settle(place, last);
    } else if (key != heap_[place].key) {
      settle(place, {key, row});
    }
  }

 private:
  static constexpr std::uint32_t kFan = 4;
  struct Entry {
    i64 key;
    std::uint32_t row;
    [[nodiscard]] bool is_before(const Entry& other) const { return key != other.key ? key < other.key : row < other.row; }
  };
  void put(std::uint32_t place, Entry entry) {
    heap_[place] = entry;
    places_[entry.row] = place;
  }
  // The entry, wherever it belongs; `place` is free.
  void settle(std::uint32_t place, Entry entry) {
    if (place != 0 && entry.is_before(heap_[(place - 1) / kFan])) rise(place, entry);
    else sink(place, entry);
  }
  void rise(std::uint32_t place, Entry entry) {
    for (; place != 0 && entry.is_before(heap_[(place - 1) / kFan]); place = (place - 1) / kFan) put(place, heap_[(place - 1) / kFan]);
    put(place, entry);
  }
  void sink(std::uint32_t place, Entry entry) {
    const auto size = static_cast<std::uint32_t>(heap_.size());
    for (std::uint32_t child = kFan * place + 1; child < size; child = kFan * place + 1) {
      const std::uint32_t end = std::min(child + kFan, size);
      std::uint32_t first = child;
      for (++child; child < end; ++child) first = heap_[child].is_before(heap_[first]) ? child : first;
      if (!heap_[first].is_before(entry)) break;
      put(place, heap_[first]);
      place = first;
    }
    put(place, entry);
  }

  std::vector<std::uint32_t> places_;   // by row, in heap_; kNone: not in it
  std::vector<Entry> heap_;
};

}  // namespace bip::rt
