// Interactions and variables are rows of different tables: mixing them, or a plain number with them, does not compile.
#include "bip/ids.hpp"

#include <catch2/catch.hpp>

#include <type_traits>

#include "runtime/core/core.hpp"

using namespace bip::rt;
using bip::IdRange;

namespace {

template <class From, class To>
constexpr bool mixes = std::is_convertible_v<From, To> || std::is_constructible_v<To, From> ||
                       std::is_assignable_v<To&, From> || std::equality_comparable_with<From, To>;
static_assert(!mixes<InteractionId, VariableId> && !mixes<VariableId, InteractionId>);

// A number becomes an id where the source says so, and an id never becomes a number.
static_assert(!std::is_convertible_v<u32, InteractionId> && std::is_constructible_v<InteractionId, u32>);
static_assert(!std::is_convertible_v<u32, VariableId> && std::is_constructible_v<VariableId, u32>);
static_assert(!std::is_convertible_v<InteractionId, u32> && !std::is_constructible_v<u32, InteractionId>);
static_assert(!std::is_convertible_v<VariableId, u32> && !std::is_constructible_v<u32, VariableId>);

// Each of the core's tables takes its own ids alone.
template <class Table, class Row>
concept IndexedBy = requires(const Table& table, Row row) {
  table[row];
};
static_assert(IndexedBy<Interactions, InteractionId> && !IndexedBy<Interactions, VariableId> &&
              !IndexedBy<Interactions, u32>);
static_assert(IndexedBy<RowsByInteraction, InteractionId> && !IndexedBy<RowsByInteraction, u32>);
static_assert(IndexedBy<InteractionsBy, u32> && !IndexedBy<InteractionsBy, InteractionId>);
template <class Row>
concept RowOfEnabledSet = requires(const EnabledSet& set, Row row) {
  set.weight(row);
};
static_assert(RowOfEnabledSet<InteractionId> && !RowOfEnabledSet<VariableId> && !RowOfEnabledSet<u32>);
template <class Row>
concept RowOfCells = requires(const Core& core, Row row) {
  core.cell(row);
};
static_assert(RowOfCells<VariableId> && !RowOfCells<InteractionId> && !RowOfCells<u32>);

// As large as a number, and passed like one.
static_assert(sizeof(InteractionId) == sizeof(u32) && alignof(InteractionId) == alignof(u32));
static_assert(sizeof(EnabledSet::Position) == 8 && sizeof(Candidate) == 20 && sizeof(HighEdge) == 8);

}  // namespace

TEST_CASE("ranges of ids") {
  std::vector<u32> seen;
  for (const InteractionId interaction : IdRange<InteractionId>(2, 5)) seen.push_back(interaction.value);
  CHECK(seen == std::vector<u32>{2, 3, 4});
  for (const VariableId variable : IdRange<VariableId>(0)) FAIL("variable " << variable.value << " of none");
}

TEST_CASE("a table from interactions to atoms, and back") {
  const std::vector<RowsByInteraction::Pair> pairs{
      {InteractionId(0u), 7}, {InteractionId(2u), 3}, {InteractionId(2u), 7}, {InteractionId(0u), 1}};
  const RowsByInteraction atoms = RowsByInteraction::build(3, pairs);
  CHECK(atoms[InteractionId(0u)][0] == 7);
  CHECK(atoms[InteractionId(0u)][1] == 1);
  CHECK(atoms[InteractionId(1u)].size == 0);
  const InteractionsBy interactions = atoms.transposed(8);
  REQUIRE(interactions[7].size == 2);
  CHECK(interactions[7][0] == InteractionId(0u));
  CHECK(interactions[7][1] == InteractionId(2u));
  CHECK(interactions[2].size == 0);
}
