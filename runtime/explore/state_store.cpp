// See state_store.hpp. Roots of a batch are computed first, then looked up with loads begun ahead of time: a look-up
// alone waits for memory twice, sixteen in flight share the wait.
#include "runtime/explore/state_store.hpp"

#include <algorithm>

#include "bip/assert.hpp"

namespace bip::rt {

namespace {

constexpr std::size_t kAheadBucket = 24, kAheadWord = 10;
constexpr std::size_t kRootsPerPiece = 4096;

}  // namespace

StateStore::StateStore(u32 words, std::size_t limit) : words_(words), limit_(limit), values_(2 * std::size_t{words}) {
  std::vector<u32> level;
  for (u32 k = 0; k < words; ++k) level.push_back(k);
  u32 next = words;
  while (level.size() > 1) {
    std::vector<u32> above;
    for (std::size_t k = 0; k + 1 < level.size(); k += 2) {
      nodes_.push_back({level[k], level[k + 1]});
      above.push_back(next++);
    }
    if (level.size() % 2 != 0) above.push_back(level.back());
    level = std::move(above);
  }
  BIP_ASSERT(words >= 1 && nodes_.size() + 1 == words, "{} nodes join {} words", nodes_.size(), words);
  sets_.resize(words == 1 ? 1 : next);
}

std::size_t StateStore::bytes() const {
  std::size_t sum = 0;
  for (const WordSet& set : sets_) sum += set.bytes();
  return sum;
}

bool StateStore::fold(const u64* state, u64& root) {
  if (words_ == 1) {
    root = state[0];
    return true;
  }
  u64* value = values_.data();
  const auto number = [&](u32 node, u64 word) {
    const u32 row = sets_[node].add(word).row;
    value[node] = row;
    return row != WordSet::kFull;
  };
  for (u32 k = 0; k < words_; ++k) {
    if (!number(k, state[k])) return false;
  }
  for (u32 k = 0; k + 1 < nodes_.size(); ++k) {
    if (!number(words_ + k, value[nodes_[k].left] << 32 | value[nodes_[k].right])) return false;
  }
  root = value[nodes_.back().left] << 32 | value[nodes_.back().right];
  return true;
}

bool StateStore::add(const u64* states, std::size_t count, std::uint8_t* is_new, u32* rows) {
  WordSet& root = sets_.back();
  roots_.resize(2 * kRootsPerPiece);
  u64* hashes = roots_.data() + kRootsPerPiece;
  for (std::size_t first = 0; first < count; first += kRootsPerPiece) {
    if (limit_ != 0) {
      std::size_t others = 0;
      for (std::size_t k = 0; k + 1 < sets_.size(); ++k) others += sets_[k].bytes();
      if (others >= limit_) return false;
      root.set_limit(limit_ - others);
    }
    const std::size_t size = std::min(kRootsPerPiece, count - first);
    for (std::size_t i = 0; i < size; ++i) {
      if (!fold(states + (first + i) * words_, roots_[i])) return false;
      hashes[i] = WordSet::hash_of(roots_[i]);
    }
    for (std::size_t i = 0; i < std::min(kAheadBucket, size); ++i) root.prefetch_bucket(hashes[i]);
    for (std::size_t i = 0; i < std::min(kAheadWord, size); ++i) root.prefetch_word(hashes[i]);
    for (std::size_t i = 0; i < size; ++i) {
      if (i + kAheadBucket < size) root.prefetch_bucket(hashes[i + kAheadBucket]);
      if (i + kAheadWord < size) root.prefetch_word(hashes[i + kAheadWord]);
      const WordSet::Found found = root.add(roots_[i], hashes[i]);
      if (found.row == WordSet::kFull) return false;
      BIP_ASSERT(is_row(found.row, states + (first + i) * words_), "row {} is another state", found.row);
      if (is_new != nullptr) is_new[first + i] = found.is_new ? 1 : 0;
      if (rows != nullptr) rows[first + i] = found.row;
    }
  }
  return true;
}

StateStore::u32 StateStore::find(const u64* state) const {
  if (words_ == 1) return sets_[0].find(state[0]);
  std::vector<u64> value(words_ + nodes_.size());
  for (u32 node = 0; node < value.size(); ++node) {
    const u64 word =
        node < words_ ? state[node] : value[nodes_[node - words_].left] << 32 | value[nodes_[node - words_].right];
    const u32 row = sets_[node].find(word);
    if (row == WordSet::kFull) return WordSet::kFull;
    value[node] = row;
  }
  return static_cast<u32>(value.back());
}

bool StateStore::is_row(u32 row, const u64* state) const {
  std::vector<u64> stored(words_), rows;
  read(row, stored.data(), rows);
  return std::equal(stored.begin(), stored.end(), state) && contains(state);
}

void StateStore::read(u32 row, u64* out, std::vector<u64>& rows) const {
  BIP_ASSERT(row < size(), "state {} of {}", row, size());
  if (words_ == 1) {
    out[0] = sets_[0][row];
    return;
  }
  rows.resize(words_ + nodes_.size());
  rows.back() = row;
  for (std::size_t node = rows.size(); node-- > words_;) {
    const u64 word = sets_[node][static_cast<u32>(rows[node])];
    rows[nodes_[node - words_].left] = word >> 32;
    rows[nodes_[node - words_].right] = word & 0xffffffffu;
  }
  for (u32 k = 0; k < words_; ++k) out[k] = sets_[k][static_cast<u32>(rows[k])];
}

}  // namespace bip::rt
