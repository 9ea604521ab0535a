// See content_hash.hpp. The hashing is libb2's (S. Neves; BLAKE2b as in RFC 7693), without a key.
#include "compiler/base/content_hash.hpp"

#include <blake2.h>

#include <array>
#include <cstdint>

namespace bip {

namespace {

class Blake2b {
 public:
  Blake2b() { blake2b_init(&state_, kDigest); }
  void add(std::string_view text) {
    blake2b_update(&state_, reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  }
  std::string digits() {
    std::array<std::uint8_t, kDigest> digest{};
    blake2b_final(&state_, digest.data(), digest.size());
    std::string text;
    for (const unsigned byte : digest) {
      text += "0123456789abcdef"[byte >> 4];
      text += "0123456789abcdef"[byte & 15];
    }
    return text;
  }

 private:
  static constexpr std::size_t kDigest = 32;
  blake2b_state state_{};
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
