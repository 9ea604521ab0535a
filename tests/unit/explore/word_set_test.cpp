// The store: what goes in comes out under its number, at every size and width, and growth beyond the limit is refused.
#include <catch2/catch.hpp>

#include <map>

#include "runtime/include/bip/prng.hpp"
#include "runtime/explore/state_store.hpp"

using namespace bip::rt;

TEST_CASE("a word set numbers words in the order in which they come") {
  WordSet set;
  Prng random(1);
  std::map<std::uint64_t, std::uint32_t> expected;
  for (int k = 0; k < 300000; ++k) {
    // Small words collide often, in the set's order too.
    const std::uint64_t word = random.below(3) == 0 ? random.next() : random.below(100000);
    const auto [at, is_new] = expected.try_emplace(word, static_cast<std::uint32_t>(expected.size()));
    const WordSet::Found found = set.add(word);
    REQUIRE(found.is_new == is_new);
    REQUIRE(found.row == at->second);
  }
  REQUIRE(set.size() == expected.size());
  for (const auto& [word, row] : expected) {
    REQUIRE(set[row] == word);
    REQUIRE(set.find(word) == row);
  }
  CHECK(set.find(~std::uint64_t{0} - 5) == WordSet::kFull);
  CHECK(static_cast<double>(set.bytes()) / set.size() < 24);
}

TEST_CASE("a word set refuses to grow beyond its limit, and keeps what it has") {
  WordSet set;
  set.set_limit(200000);
  std::uint64_t word = 0;
  while (set.add(word).row != WordSet::kFull) REQUIRE(++word < 100000);
  CHECK(set.bytes() <= 200000);
  CHECK(word > 5000);
  for (std::uint64_t k = 0; k < word; ++k) REQUIRE(set.find(k) == k);
}

TEST_CASE("states of any width are told apart by any of their words") {
  for (const std::uint32_t words : {1u, 2u, 3u, 4u, 7u}) {
    StateStore store(words, 0);
    std::map<std::vector<std::uint64_t>, std::uint32_t> expected;
    Prng random(words);
    std::vector<std::uint64_t> scratch, back(words), batch;
    for (int round = 0; round < 200; ++round) {
      batch.clear();
      for (int k = 0; k < 100; ++k) {
        std::vector<std::uint64_t> state;
        for (std::uint32_t w = 0; w < words; ++w) state.push_back(random.below(w % 2 == 0 ? 20 : 4));
        batch.insert(batch.end(), state.begin(), state.end());
        expected.try_emplace(state, static_cast<std::uint32_t>(expected.size()));
      }
      REQUIRE(store.add(batch.data(), 100));
    }
    REQUIRE(store.size() == expected.size());
    for (const auto& [state, row] : expected) {
      REQUIRE(store.contains(state.data()));
      store.read(row, back.data(), scratch);
      REQUIRE(back == state);
    }
    std::vector<std::uint64_t> absent(words, 21);
    CHECK_FALSE(store.contains(absent.data()));
  }
}
