// The availability network: which counters ports move, and that groups of which nothing needs to be known have none.
#include <catch2/catch.hpp>

#include "runtime/core/core.hpp"
#include "tests/unit/runtime/helpers.hpp"

using namespace bip::rt;
using namespace bip::rt::testing;

namespace {

// `top` over `below`, a connector of the ports of a and b, and over the port of c. Each fires once.
void make_levels(ImageBuilder& b, const std::string& below, const std::string& top) {
  b.atom_type({.name = "Once",
               .ports = {{.name = "go", .vars = {}}},
               .places = {"A", "B"},
               .initial = {"A"},
               .transitions = {{"go", {"A"}, {"B"}}}});
  for (const char* name : {"a", "b", "c"}) b.atom(name, "Once");
  b.connector_type({.name = "Below", .params = {{"p", 0}, {"q", 0}}, .define = below, .exports = true});
  b.connector_type({.name = "Top", .params = {{"l", 0}, {"r", 0}}, .define = top});
  b.connector("below", "Below", {"a.go", "b.go"});
  b.connector("top", "Top", {"below", "c.go"});
}

// How many nodes the port moves that are no interactions.
std::size_t groups_above(const Core& core, u32 atom) {
  std::size_t groups = 0;
  for (const u32 node : core.tables().port_out[core.tables().instance(atom, 0)])
    groups += core.tables().is_interaction(node) ? 0 : 1;
  return groups;
}

}  // namespace

TEST_CASE("a rendezvous of rendezvous is one counter of ports") {
  ImageBuilder b;
  make_levels(b, "p q", "l r");
  Core core(b.image());
  REQUIRE(core.initialize());
  for (u32 atom = 0; atom < 3; ++atom) CHECK(groups_above(core, atom) == 0);
  CHECK(core.tables().start_of(InteractionId(0u)) == -3);
  CHECK(core.tables().node_out.items.empty());
  CHECK(candidates(core) == Strings{"top: a.go b.go c.go"});
}

TEST_CASE("a broadcast below a rendezvous keeps its counter, and one below a broadcast does not") {
  {
    ImageBuilder b;
    make_levels(b, "p' q'", "l r");
    Core core(b.image());
    REQUIRE(core.initialize());
    CHECK(groups_above(core, 0) == 1);
    CHECK(groups_above(core, 2) == 0);
    CHECK(core.tables().start_of(InteractionId(0u)) == -2);
  }
  ImageBuilder b;
  make_levels(b, "p' q'", "l' r'");
  Core core(b.image());
  REQUIRE(core.initialize());
  CHECK(core.tables().start_of(InteractionId(0u)) == -1);
  CHECK(candidates(core) == Strings{"top: a.go b.go c.go"});
}

TEST_CASE("a group that two connectors count keeps its counter") {
  ImageBuilder b;
  make_levels(b, "p q", "l r");
  b.connector("other", "Top", {"below", "c.go"});
  Core core(b.image());
  REQUIRE(core.initialize());
  CHECK(groups_above(core, 0) == 1);
  CHECK(candidates(core) == Strings{"top: a.go b.go c.go", "other: a.go b.go c.go"});
  REQUIRE(core.fire(std::uint64_t{0}));
  CHECK(candidates(core).empty());
}
