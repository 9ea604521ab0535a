// Interactions as bits: they come back as they were, in whatever pieces they were added, and odd bytes are refused.
#include <catch2/catch.hpp>

#include <algorithm>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "runtime/distributed/fired_interactions.hpp"

using namespace bip::rt;

namespace {

// Below `count`, the largest one among them.
std::vector<u32> draw(std::mt19937_64& draws, std::size_t count, std::size_t size) {
  std::vector<u32> rows;
  for (std::size_t k = 0; k < size; ++k) rows.push_back(static_cast<u32>(draws() % count));
  if (size != 0) rows[draws() % size] = static_cast<u32>(count - 1);
  return rows;
}

}  // namespace

TEST_CASE("an interaction takes as many bits as the largest one of the model") {
  CHECK(bits_of_fired(0) == 1);
  CHECK(bits_of_fired(1) == 1);
  CHECK(bits_of_fired(2) == 1);
  CHECK(bits_of_fired(3) == 2);
  CHECK(bits_of_fired(16) == 4);
  CHECK(bits_of_fired(17) == 5);
  CHECK(bits_of_fired(kNone) == 32);
}

TEST_CASE("packed interactions come back as they were, whatever the pieces") {
  std::mt19937_64 draws(1);
  for (unsigned bits = 1; bits <= 32; ++bits) {
    for (const std::size_t size : {1u, 2u, 7u, 16u, 63u, 64u, 65u, 1000u}) {
      // The least and the largest model whose interactions take so many bits.
      const std::size_t least = bits == 1 ? 1 : (std::size_t{1} << (bits - 1)) + 1;
      const std::size_t largest = std::min<std::size_t>(std::size_t{1} << bits, kNone);
      for (const std::size_t count : {least, largest}) {
        REQUIRE(bits_of_fired(count) == bits);
        const std::vector<u32> rows = draw(draws, count, size);
        FiredPacker packer(count);
        for (std::size_t at = 0; at < size;) {
          const std::size_t piece = std::min<std::size_t>(draws() % 40, size - at);
          packer.add(std::span(rows).subspan(at, piece));
          at += piece;
          CHECK(packer.count() == at);
          CHECK(packer.size() == (at * bits + 7) / 8);
        }
        const std::string bytes = packer.take();
        REQUIRE(bytes.size() == (size * bits + 7) / 8);
        CHECK(packer.count() == 0);
        CHECK(packer.size() == 0);
        std::vector<InteractionId> out{InteractionId(3u)};
        REQUIRE(unpack_fired(bytes, size, count, out));
        REQUIRE(out.size() == 1 + size);
        CHECK(out[0] == InteractionId(3u));
        for (std::size_t k = 0; k < size; ++k) REQUIRE(out[1 + k] == InteractionId(rows[k]));
        // What was packed before leaves nothing behind.
        packer.add(rows);
        CHECK(packer.take() == bytes);
        // Fewer or more bytes, or interactions.
        CHECK_FALSE(unpack_fired(bytes + '\0', size, count, out));
        CHECK_FALSE(unpack_fired(std::string_view(bytes).substr(1), size, count, out));
        CHECK_FALSE(unpack_fired(bytes, size + 8, count, out));
        CHECK(out.size() == 1 + size);
      }
    }
  }
}

TEST_CASE("bytes that are no packed interactions of the model are refused") {
  std::vector<InteractionId> out;
  CHECK(unpack_fired("", 0, 5, out));
  CHECK_FALSE(unpack_fired("", 1, 5, out));
  CHECK_FALSE(unpack_fired("\x01", 0, 5, out));
  CHECK_FALSE(unpack_fired("\x01", ~u64{0}, 5, out));
  CHECK_FALSE(unpack_fired("\x01", (~u64{0} >> 1) + 1, 1, out));
  // Five are not in the model, nor are the last two bits an interaction.
  CHECK(unpack_fired("\x0c", 2, 5, out));
  CHECK_FALSE(unpack_fired("\x0d", 2, 5, out));
  CHECK_FALSE(unpack_fired("\x4c", 2, 5, out));
  CHECK_FALSE(unpack_fired(std::string_view("\0", 1), 1, 0, out));
  CHECK(out == std::vector<InteractionId>{InteractionId(4u), InteractionId(1u)});
}
