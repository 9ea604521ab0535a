// An exact set of 64-bit words that numbers them: the only container that grows with the number of states.
//
// Words lie in the order in which they came, 8 bytes each; an index of 32-bit rows finds them. The index is buckets of
// one cache line: 12 rows and 8 bits of each word's hash, so that a look-up reads one line, and one word where the bits
// agree (1 of 256 that differ agree by chance; the word decides, so nothing is lost). At 55 to 85 percent full a word
// costs 8 + 6.3 to 9.7 bytes. To grow, the index is thrown away before the new one is made from the words: no moment
// needs two. Not thread-safe. No more than 2^32 - 2 words.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "bip/assert.hpp"

namespace bip::rt {

class WordSet {
 public:
  using u32 = std::uint32_t;
  using u64 = std::uint64_t;
  static constexpr u32 kFull = 0xffffffffu;

  WordSet();
  struct Found {
    u32 row;  // kFull: the memory that is allowed does not suffice
    bool is_new;
  };
  /// The row of the word, added if it is new. Expected O(1).
  Found add(u64 word) { return add(word, hash_of(word)); }
  Found add(u64 word, u64 hash);
  /// kFull: not there.
  [[nodiscard]] u32 find(u64 word) const;
  [[nodiscard]] u64 operator[](u32 row) const {
    BIP_ASSERT(row < size_, "row {} of {}", row, size_);
    return chunks_[row >> kChunkBits][row & kChunkMask];
  }
  [[nodiscard]] u32 size() const { return size_; }
  /// What it holds, and what it would hold after the next growth of the index.
  [[nodiscard]] std::size_t bytes() const;
  /// Growth beyond this is refused. 0: no limit.
  void set_limit(std::size_t bytes) { limit_ = bytes; }

  /// The two loads of a look-up, begun early: first the bucket; some time later the word that it will be compared with.
  void prefetch_bucket(u64 hash) const { __builtin_prefetch(&buckets_[bucket_of(hash)]); }
  void prefetch_word(u64 hash) const;

  /// Every bit depends on every bit of the word (the finalizer of MurmurHash3, Appleby 2011); a bijection.
  [[nodiscard]] static u64 hash_of(u64 word) {
    word ^= word >> 33;
    word *= 0xff51afd7ed558ccdull;
    word ^= word >> 33;
    word *= 0xc4ceb9fe1a85ec53ull;
    return word ^ (word >> 33);
  }

 private:
  static constexpr u32 kChunkBits = 16;
  static constexpr u32 kChunkMask = (1u << kChunkBits) - 1;
  static constexpr u32 kRows = 12;
  struct alignas(64) Bucket {
    std::uint8_t tags[kRows];
    std::uint8_t count;
    std::uint8_t unused[3];
    u32 rows[kRows];
  };
  static_assert(sizeof(Bucket) == 64);
  struct Free {
    void operator()(void* memory) const;
  };

  // The upper bits choose the bucket (Lemire 2019: a multiplication instead of a division), the lowest are the tag.
  [[nodiscard]] u64 bucket_of(u64 hash) const {
    __extension__ using u128 = unsigned __int128;
    return static_cast<u64>(static_cast<u128>(hash) * bucket_count_ >> 64);
  }
  // Bit k: the k-th tag of the bucket agrees.
  [[nodiscard]] static u32 agreeing(const Bucket& bucket, u64 hash);
  [[nodiscard]] u32 find(u64 word, u64 hash, u64& bucket) const;
  bool grow();
  bool add_room();
  bool make_index(u64 buckets);
  void insert(u64 hash, u64 bucket, u32 row);
  // Is each word found in its row? For assertions.
  [[nodiscard]] bool is_index_complete() const;

  std::vector<std::unique_ptr<u64[]>> chunks_;
  std::unique_ptr<Bucket[], Free> buckets_;
  u64 bucket_count_ = 0;
  u32 size_ = 0, grow_at_ = 0, room_ = 0;
  std::size_t limit_ = 0;
};

}  // namespace bip::rt
