// Many interactions as bytes, each of them in as many bits as the largest one needs: 16 interactions take 4 bits each.
// A node sends those of all steps that it took alone, and what each byte costs on its way, its encryption above all, is
// more than a step of a small model.
//
// Little-endian: the first interaction is in the lowest bits of the first byte. The bits behind the last one are 0.
#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/core/link/tables.hpp"

namespace bip::rt {

/// Bits of each interaction of a model that has `count` of them: 1 to 32.
[[nodiscard]] unsigned bits_of_fired(std::size_t count);

class FiredPacker {
 public:
  /// For a model with `count` interactions.
  explicit FiredPacker(std::size_t count) : bits_(bits_of_fired(count)) {}
  /// Requires that each is less than the model's count. O(1) each.
  void add(std::span<const u32> interactions);
  /// How many were added since the last take().
  [[nodiscard]] u64 count() const { return count_; }
  /// Bytes of them.
  [[nodiscard]] std::size_t size() const { return bytes_.size() + (filled_ + 7) / 8; }
  /// Returns the bytes of all, and starts anew.
  [[nodiscard]] std::string take();

 private:
  unsigned bits_;
  unsigned filled_ = 0;  // bits of `word_` that are no part of `bytes_` yet, less than 64
  u64 word_ = 0;
  u64 count_ = 0;
  std::string bytes_;
};

/// Appends the `packed` interactions of a model that has `count` of them to `out`. False, and nothing is appended: the
/// bytes are not those of so many interactions of the model.
[[nodiscard]] bool unpack_fired(std::string_view bytes, u64 packed, std::size_t count, std::vector<InteractionId>& out);

}  // namespace bip::rt
