// See word_set.hpp.
#include "runtime/explore/word_set.hpp"

#include <bit>
#include <cstdlib>
#include <cstring>
#include <new>
#if defined(__SSE2__)
#include <emmintrin.h>
#endif
#if defined(__linux__)
#include <sys/mman.h>

#include "bip/assert.hpp"
#endif

namespace bip::rt {

namespace {

// Small at first: the search for paths keeps a set for each level.
constexpr std::uint64_t kFirstBuckets = 2;
constexpr std::uint32_t kFirstWords = 32;
constexpr std::size_t kHugePage = std::size_t{1} << 21;
// Fill at which the index grows, and by how much it grows, as fractions.
constexpr std::uint64_t kFillNumerator = 85, kFillDenominator = 100;
constexpr std::uint64_t kGrowNumerator = 155, kGrowDenominator = 100;

}  // namespace

void WordSet::Free::operator()(void* memory) const { std::free(memory); }

WordSet::WordSet() { (void)make_index(kFirstBuckets); }

bool WordSet::make_index(u64 buckets) {
  buckets_.reset();
  bucket_count_ = 0;
  const std::size_t bytes = buckets * sizeof(Bucket);
  const bool is_large = bytes >= 4 * kHugePage;
  const std::size_t alignment = is_large ? kHugePage : alignof(Bucket);
  const std::size_t rounded = (bytes + alignment - 1) / alignment * alignment;
  void* memory = std::aligned_alloc(alignment, rounded);
  if (memory == nullptr) return false;
#if defined(__linux__)
  // Look-ups go everywhere: with small pages each would miss the TLB as well.
  if (is_large) (void)madvise(memory, rounded, MADV_HUGEPAGE);
#endif
  std::memset(memory, 0, rounded);
  buckets_.reset(static_cast<Bucket*>(memory));
  bucket_count_ = buckets;
  const u64 limit = buckets * kRows * kFillNumerator / kFillDenominator;
  grow_at_ = limit < kFull - 1 ? static_cast<u32>(limit) : kFull - 1;
  return true;
}

std::size_t WordSet::bytes() const {
  return bucket_count_ * sizeof(Bucket) + (std::size_t{size_} * sizeof(u64) + 4095) / 4096 * 4096;
}

bool WordSet::grow() {
  const u64 buckets = bucket_count_ * kGrowNumerator / kGrowDenominator + 1;
  if (size_ >= kFull - 1) return false;
  if (limit_ != 0 && buckets * sizeof(Bucket) + std::size_t{size_} * sizeof(u64) > limit_) return false;
  const u64 before = bucket_count_;
  const bool is_made = make_index(buckets);
  // Not even so much: the index that there was.
  if (!is_made && !make_index(before)) return false;
  constexpr u32 kAhead = 16;
  for (u32 row = 0; row < size_; ++row) {
    if (row + kAhead < size_) __builtin_prefetch(&buckets_[bucket_of(hash_of((*this)[row + kAhead]))], 1);
    const u64 hash = hash_of((*this)[row]);
    insert(hash, bucket_of(hash), row);
  }
  BIP_ASSERT(is_index_complete(), "{} words in {} buckets", size_, bucket_count_);
  return is_made;
}

bool WordSet::is_index_complete() const {
  for (u32 row = 0; row < size_; ++row) {
    if (find((*this)[row]) != row) return false;
  }
  return true;
}

inline void WordSet::insert(u64 hash, u64 at, u32 row) {
  BIP_ASSERT(row < grow_at_ && at < bucket_count_, "row {} into bucket {}", row, at);
  while (buckets_[at].count == kRows) at = at + 1 == bucket_count_ ? 0 : at + 1;
  Bucket& bucket = buckets_[at];
  bucket.tags[bucket.count] = static_cast<std::uint8_t>(hash);
  bucket.rows[bucket.count] = row;
  ++bucket.count;
}

inline WordSet::u32 WordSet::agreeing(const Bucket& bucket, u64 hash) {
  const u32 used = (1u << bucket.count) - 1;
#if defined(__SSE2__)
  const __m128i tags = _mm_load_si128(reinterpret_cast<const __m128i*>(&bucket));
  const __m128i wanted = _mm_set1_epi8(static_cast<char>(hash & 0xff));
  return static_cast<u32>(_mm_movemask_epi8(_mm_cmpeq_epi8(tags, wanted))) & used;
#else
  u32 bits = 0;
  for (u32 k = 0; k < kRows; ++k) bits |= static_cast<u32>(bucket.tags[k] == static_cast<std::uint8_t>(hash)) << k;
  return bits & used;
#endif
}

void WordSet::prefetch_word(u64 hash) const {
  const Bucket& bucket = buckets_[bucket_of(hash)];
  const u32 bits = agreeing(bucket, hash);
  if (bits == 0) return;
  const u32 row = bucket.rows[std::countr_zero(bits)];
  __builtin_prefetch(&chunks_[row >> kChunkBits][row & kChunkMask]);
}

inline WordSet::u32 WordSet::find(u64 word, u64 hash, u64& at) const {
  at = bucket_of(hash);
  for (;;) {
    const Bucket& bucket = buckets_[at];
    for (u32 bits = agreeing(bucket, hash); bits != 0; bits &= bits - 1) {
      const u32 row = bucket.rows[std::countr_zero(bits)];
      if ((*this)[row] == word) return row;
    }
    if (bucket.count != kRows) return kFull;
    at = at + 1 == bucket_count_ ? 0 : at + 1;
  }
}

WordSet::u32 WordSet::find(u64 word) const {
  u64 at = 0;
  return find(word, hash_of(word), at);
}

// The first piece doubles until it is a whole one.
bool WordSet::add_room() {
  const u32 size = size_ == 0 ? kFirstWords : size_ <= kChunkMask ? 2 * size_ : kChunkMask + 1;
  std::unique_ptr<u64[]> piece(new (std::nothrow) u64[size]);
  if (piece == nullptr) return false;
  if (size_ != 0 && size_ <= kChunkMask) {
    std::memcpy(piece.get(), chunks_[0].get(), size_ * sizeof(u64));
    chunks_[0] = std::move(piece);
    room_ = size;
  } else {
    chunks_.push_back(std::move(piece));
    room_ += size;
  }
  return true;
}

WordSet::Found WordSet::add(u64 word, u64 hash) {
  if (bucket_count_ == 0) return {kFull, false};
  u64 at = 0;
  if (const u32 row = find(word, hash, at); row != kFull) return {row, false};
  if (size_ >= grow_at_) {
    if (!grow()) return {kFull, false};
    at = bucket_of(hash);
  }
  // A page of words at a time.
  if (limit_ != 0 && (size_ & 511) == 0 && bytes() + 4096 > limit_) return {kFull, false};
  if (size_ == room_ && !add_room()) return {kFull, false};
  BIP_ASSERT(size_ < room_ && size_ < kFull - 1, "{} words, room for {}", size_, room_);
  chunks_.back()[size_ & kChunkMask] = word;
  insert(hash, at, size_);
  return {size_++, true};
}

}  // namespace bip::rt
