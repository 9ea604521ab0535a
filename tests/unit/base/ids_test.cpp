// Ids, index vectors, arena and Result.
#include "runtime/include/bip/ids.hpp"

#include <catch2/catch.hpp>

#include "compiler/base/arena.hpp"
#include "compiler/base/result.hpp"

namespace {
using FruitId = bip::Id<struct FruitTag>;
}

TEST_CASE("a default id is not valid, a pushed one is") {
  bip::IndexVector<FruitId, std::string> fruits;
  REQUIRE_FALSE(FruitId{}.is_valid());
  REQUIRE_FALSE(fruits.contains(FruitId{}));
  const FruitId apple = fruits.push("apple");
  const FruitId pear = fruits.push("pear");
  REQUIRE(apple < pear);
  REQUIRE(fruits[pear] == "pear");
  REQUIRE(fruits.contains(pear));
  REQUIRE(fruits.size() == 2);
}

TEST_CASE("an arena copies lists and texts, and they stay where they are") {
  bip::Arena arena;
  std::vector<int> numbers{1, 2, 3};
  const std::span<const int> kept = arena.list(numbers);
  numbers.assign(3, 0);
  REQUIRE(kept[2] == 3);
  std::string text = "name";
  const std::string_view view = arena.text(text);
  text = "gone";
  for (int i = 0; i < 10000; ++i) arena.make(i);
  REQUIRE(view == "name");
  REQUIRE(arena.list(std::vector<int>{}).empty());
  REQUIRE(arena.text("").empty());
}

TEST_CASE("a result is a value or a message") {
  const bip::Result<int> good = 3;
  const bip::Result<int> bad = bip::Failure{"no"};
  REQUIRE(good);
  REQUIRE(*good == 3);
  REQUIRE_FALSE(bad);
  REQUIRE(bad.error() == "no");
}
