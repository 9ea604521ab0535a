// See fired_interactions.hpp.
#include "runtime/distributed/fired_interactions.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "bip/assert.hpp"

namespace bip::rt {

namespace {

constexpr unsigned kWord = 64;

void store(u64 word, char* at, unsigned bytes) {
  for (unsigned i = 0; i < bytes; ++i) at[i] = static_cast<char>(word >> (8 * i) & 0xff);
}

u64 load(const char* at, std::size_t bytes) {
  u64 word = 0;
  for (std::size_t i = 0; i < bytes; ++i) word |= u64{static_cast<unsigned char>(at[i])} << (8 * i);
  return word;
}

}  // namespace

unsigned bits_of_fired(std::size_t count) {
  return std::max(1u, static_cast<unsigned>(std::bit_width(std::max<std::size_t>(count, 1) - 1)));
}

void FiredPacker::add(std::span<const u32> interactions) {
  const std::size_t before = bytes_.size();
  const u64 words = (filled_ + u64{bits_} * interactions.size()) / kWord;
  bytes_.resize(before + words * 8);
  char* at = bytes_.data() + before;
  u64 word = word_;
  unsigned filled = filled_;
  for (const u32 interaction : interactions) {
    word |= u64{interaction} << filled;
    filled += bits_;
    if (filled < kWord) continue;
    store(word, at, 8);
    at += 8;
    filled -= kWord;
    // The interaction's bits that had no room; `filled` of them, and a shift by all of its bits leaves none.
    word = u64{interaction} >> (bits_ - filled);
  }
  BIP_ASSERT(at == bytes_.data() + bytes_.size(), "{} words of {}", (at - bytes_.data()) / 8, words);
  word_ = word;
  filled_ = filled;
  count_ += interactions.size();
}

std::string FiredPacker::take() {
  const unsigned rest = (filled_ + 7) / 8;
  bytes_.resize(bytes_.size() + rest);
  store(word_, bytes_.data() + bytes_.size() - rest, rest);
  word_ = filled_ = 0;
  count_ = 0;
  return std::exchange(bytes_, {});
}

bool unpack_fired(std::string_view bytes, u64 packed, std::size_t count, std::vector<InteractionId>& out) {
  const unsigned bits = bits_of_fired(count);
  // So many that the sum of their bits has no overflow.
  if (packed > u64{bytes.size()} * 8 / bits || (packed * bits + 7) / 8 != bytes.size()) return false;
  const std::size_t before = out.size();
  out.resize(before + packed);
  const u64 mask = (u64{1} << bits) - 1;
  std::size_t at = 0;
  u64 word = 0;
  unsigned left = 0;  // bits of `word`
  u64 largest = 0;
  for (auto each = out.begin() + static_cast<std::ptrdiff_t>(before); each != out.end(); ++each) {
    u64 value = word;
    if (left < bits) {
      const std::size_t loaded = std::min<std::size_t>(8, bytes.size() - at);
      const u64 next = load(bytes.data() + at, loaded);
      at += loaded;
      // `left` bits of the word before, then those of the next one.
      value |= next << left;
      word = next >> (bits - left);
      left += static_cast<unsigned>(loaded) * 8 - bits;
    } else {
      word >>= bits;
      left -= bits;
    }
    value &= mask;
    largest = std::max(largest, value);
    *each = InteractionId(static_cast<u32>(value));
  }
  if ((packed == 0 || largest < count) && word == 0 && at == bytes.size()) return true;
  out.resize(before);
  return false;
}

}  // namespace bip::rt
