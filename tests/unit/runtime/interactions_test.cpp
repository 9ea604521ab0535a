// Packed interactions say what was put in; those that come in order take next to nothing.
#include <catch2/catch.hpp>

#include <vector>

#include "bip/prng.hpp"
#include "runtime/core/link/interactions.hpp"

using namespace bip::rt;

namespace {

// A connector of two or of three ports, as `is_wide` says; each `hidden`-th row of connectors is no interaction.
std::vector<InteractionInfo> flat(std::size_t count, bool (*is_wide)(std::size_t), u32 hidden) {
  std::vector<InteractionInfo> all;
  u32 row = 0, first = 0;
  for (std::size_t i = 0; i < count; ++i, ++row) {
    if (hidden != 0 && row % hidden == 0) ++row;
    InteractionInfo info;
    info.row = row;
    info.first = first;
    info.ref = is_wide(i) ? 3 : kNone;
    info.count = is_wide(i) ? 3 : 2;
    info.searched = is_wide(i);
    first += info.count;
    all.push_back(info);
  }
  return all;
}

std::size_t check(const std::vector<InteractionInfo>& all) {
  Interactions interactions;
  InteractionPacker packer(interactions);
  for (const InteractionInfo& info : all) packer.add(info);
  packer.finish();
  REQUIRE(interactions.size() == all.size());
  bool same = true;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const InteractionInfo info = interactions[InteractionId(i)];
    same = same && info.row == all[i].row && info.first == all[i].first && info.ref == all[i].ref &&
           info.count == all[i].count && info.kind == all[i].kind && info.searched == all[i].searched;
  }
  CHECK(same);
  return interactions.bytes();
}

}  // namespace

TEST_CASE("interactions that come in order stand once") {
  for (const std::size_t count : {0u, 1u, 63u, 64u, 65u, 1000u, 6400u}) {
    CHECK(check(flat(
              count, [](std::size_t) { return false; }, 0)) <= 2048 + count / 5);
    CHECK(check(flat(
              count, [](std::size_t i) { return i % 2 == 0; }, 0)) <= 2048 + count / 5);
    CHECK(check(flat(
              count, [](std::size_t i) { return i % 3 == 1; }, 0)) <= 4096 + count / 5);
    CHECK(check(flat(
              count, [](std::size_t i) { return i % 2 == 0; }, 8)) <= 16384 + count / 5);
  }
}

TEST_CASE("interactions in no order are what they were, 16 bytes each") {
  static Prng numbers(5);
  const std::size_t bytes = check(flat(
      6400, [](std::size_t) { return numbers.below(2) == 0; }, 5));
  CHECK(bytes <= 6400 * 17);
  CHECK(bytes >= 6400 * 16);
}

TEST_CASE("connectors, then ports, then a block that is not full") {
  std::vector<InteractionInfo> all = flat(
      100, [](std::size_t) { return false; }, 0);
  for (u32 i = 0; i < 100; ++i) {
    InteractionInfo info;
    info.kind = InteractionKind::Port;
    info.row = 7 + 3 * i;
    info.first = 200;
    all.push_back(info);
  }
  InteractionInfo plan;
  plan.kind = InteractionKind::Planned;
  plan.ref = 4;
  plan.searched = true;
  all.insert(all.begin() + 50, plan);
  check(all);
}
