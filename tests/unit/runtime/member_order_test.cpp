// The order of a list's members against a plain set, with members that leave without a word.
#include "runtime/core/state/member_order.hpp"

#include <catch2/catch.hpp>

#include <set>

#include "bip/prng.hpp"

using namespace bip::rt;

TEST_CASE("the next member in interaction order") {
  const std::uint32_t size = GENERATE(1u, 63u, 64u, 65u, 4095u, 4096u, 4097u, 300'000u);
  MemberOrder order;
  order.reset(size);
  std::vector<std::uint32_t> position(size, kAbsentInteraction);
  std::set<InteractionId> members;
  Prng prng(size);
  for (int round = 0; round < 5000; ++round) {
    const InteractionId interaction(prng.below(size));
    if (prng.below(5) < 3) {
      position[interaction.value] = 0;
      members.insert(interaction);
      order.mark(interaction);
    } else {
      position[interaction.value] = kAbsentInteraction;
      members.erase(interaction);
    }
    if (members.empty()) continue;
    const InteractionId from(prng.below(std::uint64_t{size} + 1));
    const auto at = members.lower_bound(from);
    REQUIRE(order.next(from, position.data()) == (at == members.end() ? *members.begin() : *at));
  }
  // The last one, from behind it.
  const InteractionId last(size - 1);
  position[last.value] = 0;
  order.mark(last);
  CHECK(order.next(last, position.data()) == last);
}
