// See content_hash.hpp. Without a key, and with the parameters of sequential hashing, as in RFC 7693, Section 3.
#include "compiler/base/content_hash.hpp"

#include <array>
#include <bit>
#include <cstdint>

namespace bip {

namespace {

constexpr std::size_t kBlock = 128, kDigest = 32;
constexpr std::array<std::uint64_t, 8> kStart = {0x6a09e667f3bcc908, 0xbb67ae8584caa73b, 0x3c6ef372fe94f82b, 0xa54ff53a5f1d36f1,
                                                 0x510e527fade682d1, 0x9b05688c2b3e6c1f, 0x1f83d9abfb41bd6b, 0x5be0cd19137e2179};
constexpr std::uint8_t kOrder[12][16] = {{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15}, {14, 10, 4, 8, 9, 15, 13, 6, 1, 12, 0, 2, 11, 7, 5, 3},
                                         {11, 8, 12, 0, 5, 2, 15, 13, 10, 14, 3, 6, 7, 1, 9, 4}, {7, 9, 3, 1, 13, 12, 11, 14, 2, 6, 5, 10, 4, 0, 15, 8},
                                         {9, 0, 5, 7, 2, 4, 10, 15, 14, 1, 11, 12, 6, 8, 3, 13}, {2, 12, 6, 10, 0, 11, 8, 3, 4, 13, 7, 5, 15, 14, 1, 9},
                                         {12, 5, 1, 15, 14, 13, 4, 10, 0, 7, 6, 3, 9, 2, 8, 11}, {13, 11, 7, 14, 12, 1, 3, 9, 5, 0, 15, 4, 8, 6, 2, 10},
                                         {6, 15, 14, 9, 11, 3, 0, 8, 12, 2, 13, 7, 1, 4, 10, 5}, {10, 2, 8, 4, 7, 6, 1, 5, 15, 11, 9, 14, 3, 12, 13, 0},
                                         {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15}, {14, 10, 4, 8, 9, 15, 13, 6, 1, 12, 0, 2, 11, 7, 5, 3}};

class Blake2b {
 public:
  Blake2b() { state_[0] ^= 0x01010000 ^ kDigest; }

  void add(std::string_view text) {
    while (!text.empty()) {
      // The last block is compressed at the end, even if it is full.
      if (filled_ == kBlock) compress(kBlock, false);
      const std::size_t count = std::min(text.size(), kBlock - filled_);
      for (std::size_t k = 0; k < count; ++k) block_[filled_ + k] = static_cast<std::uint8_t>(text[k]);
      filled_ += count;
      text.remove_prefix(count);
    }
  }

  std::string digits() {
    for (std::size_t k = filled_; k < kBlock; ++k) block_[k] = 0;
    compress(filled_, true);
    std::string text;
    for (std::size_t k = 0; k < kDigest; ++k) {
      const unsigned byte = static_cast<unsigned>(state_[k / 8] >> (8 * (k % 8))) & 0xff;
      text += "0123456789abcdef"[byte >> 4];
      text += "0123456789abcdef"[byte & 15];
    }
    return text;
  }

 private:
  void compress(std::size_t bytes, bool is_last) {
    length_ += bytes;
    std::array<std::uint64_t, 16> m{}, v{};
    for (std::size_t k = 0; k < kBlock; ++k) m[k / 8] |= std::uint64_t{block_[k]} << (8 * (k % 8));
    for (std::size_t k = 0; k < 8; ++k) {
      v[k] = state_[k];
      v[k + 8] = kStart[k];
    }
    v[12] ^= length_;
    if (is_last) v[14] = ~v[14];
    const auto mix = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d, std::uint64_t x, std::uint64_t y) {
      v[a] += v[b] + x;
      v[d] = std::rotr(v[d] ^ v[a], 32);
      v[c] += v[d];
      v[b] = std::rotr(v[b] ^ v[c], 24);
      v[a] += v[b] + y;
      v[d] = std::rotr(v[d] ^ v[a], 16);
      v[c] += v[d];
      v[b] = std::rotr(v[b] ^ v[c], 63);
    };
    for (const auto& order : kOrder) {
      for (std::size_t k = 0; k < 4; ++k) mix(k, 4 + k, 8 + k, 12 + k, m[order[2 * k]], m[order[2 * k + 1]]);
      for (std::size_t k = 0; k < 4; ++k) mix(k, 4 + (k + 1) % 4, 8 + (k + 2) % 4, 12 + (k + 3) % 4, m[order[8 + 2 * k]], m[order[9 + 2 * k]]);
    }
    for (std::size_t k = 0; k < 8; ++k) state_[k] ^= v[k] ^ v[k + 8];
    filled_ = 0;
  }

  std::array<std::uint64_t, 8> state_ = kStart;
  std::array<std::uint8_t, kBlock> block_{};
  std::size_t filled_ = 0;
  // Of 2^64 bytes and more nobody has a text.
  std::uint64_t length_ = 0;
};

}  // namespace

std::string blake2b(std::string_view text) {
  Blake2b hash;
  hash.add(text);
  return hash.digits();
}

std::string content_hash(const std::vector<std::string_view>& texts) {
  Blake2b hash;
  for (const std::string_view text : texts) {
    char size[8];
    for (unsigned k = 0; k < 8; ++k) size[k] = static_cast<char>(std::uint64_t{text.size()} >> (8 * k));
    hash.add({size, 8});
    hash.add(text);
  }
  return hash.digits();
}

}  // namespace bip
