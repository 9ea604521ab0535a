// Trees of connectors, and their interactions in order: by hand, and on random trees against lists made all at once.
#include "compiler/analysis/interaction_tree.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "tests/unit/system/instantiated.hpp"

namespace {

using namespace bip::analysis;
using Kind = InteractionTree::Kind;

bip::ConnectorId connector_called(const bip::System& system, const std::string& path) {
  for (std::size_t row = 0; row < system.connectors.size(); ++row) {
    if (system.connectors[bip::ConnectorId(row)].path == path) return bip::ConnectorId(row);
  }
  FAIL("no connector " << path);
  return {};
}

// By interaction the ports, "a.p b.p".
std::vector<std::string> interactions_of(const bip::System& system, const InteractionTree& tree, std::size_t limit) {
  std::vector<std::string> out;
  auto all = list_interactions(tree, tree.uses[0].root, limit);
  REQUIRE(all);
  for (const Leaves& leaves : *all) {
    out.emplace_back();
    for (u32 leaf : leaves) {
      const bip::Atom& atom = system.atoms[tree.nodes[leaf].atom];
      out.back() += (out.back().empty() ? "" : " ") + atom.path.substr(5) + '.' +
                    system.atom_types[atom.type].ports[tree.nodes[leaf].port].name;
    }
  }
  return out;
}

// All interactions of a node at once, by the definition.
std::vector<Leaves> listed(const InteractionTree& tree, u32 row) {
  const InteractionTree::Node& node = tree.nodes[row];
  if (node.kind == Kind::Leaf) return {{row}};
  std::vector<Leaves> all;
  if (node.kind != Kind::Group) {
    for (u32 child : node.children) {
      for (Leaves& leaves : listed(tree, child)) all.push_back(std::move(leaves));
    }
    return all;
  }
  std::vector<std::pair<Leaves, bool>> found{{{}, !node.has_trigger}};
  for (u32 child : node.children) {
    std::vector<std::pair<Leaves, bool>> next;
    if (node.has_trigger) next = found;
    for (const auto& [leaves, triggered] : found) {
      for (const Leaves& more : listed(tree, child)) {
        next.emplace_back(leaves, triggered || tree.nodes[child].is_trigger);
        next.back().first.insert(next.back().first.end(), more.begin(), more.end());
      }
    }
    found = std::move(next);
  }
  for (auto& [leaves, triggered] : found) {
    if (triggered && !leaves.empty()) all.push_back(std::move(leaves));
  }
  return all;
}

u32 add_random(InteractionTree& tree, std::mt19937& random, u32 depth) {
  const u32 row = static_cast<u32>(tree.nodes.size());
  tree.nodes.emplace_back();
  const auto pick = random() % 8;
  const Kind kind = depth == 0 || pick < 3 ? Kind::Leaf : pick < 6 ? Kind::Group : pick < 7 ? Kind::Link : Kind::Choice;
  tree.nodes[row].kind = kind;
  const std::size_t children = kind == Kind::Leaf ? 0 : kind == Kind::Link ? 1 : random() % 4;
  const bool may_trigger = kind == Kind::Group && random() % 2 == 0;
  for (std::size_t k = 0; k < children; ++k) {
    const u32 child = add_random(tree, random, depth - 1);
    tree.nodes[child].is_trigger = may_trigger && random() % 2 == 0;
    tree.nodes[row].has_trigger = tree.nodes[row].has_trigger || tree.nodes[child].is_trigger;
    tree.nodes[row].children.push_back(child);
  }
  tree.nodes[row].end = static_cast<u32>(tree.nodes.size());
  return row;
}

}  // namespace

TEST_CASE("a rendezvous has one interaction, a broadcast counts from its trigger on") {
  const bip::test::Instantiated t(bip::test::with_types(R"(
connector type Cast(P a, P b, P c) define a' b c end
compound type R()
  component A a(1), b(2), c(3)
  connector Two two(a.p, b.p)
  connector Cast cast(a.q, b.q, c.q)
end)"));
  INFO(t.codes());
  REQUIRE(t.system);
  auto two = build_interaction_tree(*t.system, connector_called(*t.system, "ROOT.two"));
  REQUIRE(two);
  CHECK(interactions_of(*t.system, *two, 10) == std::vector<std::string>{"a.p b.p"});
  auto cast = build_interaction_tree(*t.system, connector_called(*t.system, "ROOT.cast"));
  REQUIRE(cast);
  CHECK(interactions_of(*t.system, *cast, 4) == std::vector<std::string>{"a.q", "a.q b.q", "a.q c.q", "a.q b.q c.q"});
  auto limited = list_interactions(*cast, cast->uses[0].root, 3);
  REQUIRE_FALSE(limited);
  CHECK(limited.error() == "it has more than 3 interactions");
}

TEST_CASE("bound connectors stand in place of the parameters that name them") {
  const bip::test::Instantiated t(bip::test::with_types(R"(
compound type R()
  component A a(1), b(2), c(3)
  connector Maybe inner(a.p, b.p)
  connector Two outer(inner.x, c.p)
end)"));
  INFO(t.codes());
  REQUIRE(t.system);
  auto tree = build_interaction_tree(*t.system, connector_called(*t.system, "ROOT.outer"));
  REQUIRE(tree);
  CHECK(interactions_of(*t.system, *tree, 10) == std::vector<std::string>{"a.p c.p", "a.p b.p c.p"});
  REQUIRE(tree->uses.size() == 2);
  const u32 link = tree->uses[0].param_nodes[0];
  CHECK(tree->nodes[link].kind == Kind::Link);
  CHECK(tree->nodes[link].use == 1);
  CHECK(tree->is_below(link, tree->uses[1].param_nodes[1]));
  CHECK_FALSE(tree->is_below(link, tree->uses[0].param_nodes[1]));
  const std::vector<std::uint8_t> chosen = chosen_nodes(*tree, {tree->uses[1].param_nodes[0]});
  CHECK(chosen[link] == 1);
  CHECK(chosen[tree->uses[0].param_nodes[1]] == 0);
  CHECK(chosen_alternative(*tree, link, chosen) == link);
  CHECK_FALSE(
      build_interaction_tree(*t.system, connector_called(*t.system, "ROOT.outer"), {.nodes = 20000, .depth = 0}));
  CHECK_FALSE(build_interaction_tree(*t.system, connector_called(*t.system, "ROOT.outer"), {.nodes = 3, .depth = 200}));
}

TEST_CASE("a broadcast of thirty receivers is enumerated one by one") {
  InteractionTree tree;
  tree.nodes.push_back({.kind = Kind::Group, .has_trigger = true, .end = 32, .children = {}});
  for (u32 k = 1; k <= 31; ++k) {
    tree.nodes.push_back({.kind = Kind::Leaf, .is_trigger = k == 1, .end = k + 1, .children = {}});
    tree.nodes[0].children.push_back(k);
  }
  InteractionEnumerator enumerator(tree, 0);
  Leaves leaves;
  for (int k = 0; k < 5; ++k) REQUIRE(enumerator.next(leaves));
  CHECK(leaves == Leaves{1, 4});
  CHECK_FALSE(list_interactions(tree, 0, 100));
}

TEST_CASE("triggers that are bound to nothing end the enumeration") {
  InteractionTree tree;
  tree.nodes.push_back({.kind = Kind::Group, .has_trigger = true, .end = 42, .children = {}});
  for (u32 k = 1; k <= 41; ++k) {
    tree.nodes.push_back(
        {.kind = k == 41 ? Kind::Choice : Kind::Leaf, .is_trigger = k == 41, .end = k + 1, .children = {}});
    tree.nodes[0].children.push_back(k);
  }
  InteractionEnumerator enumerator(tree, 0);
  Leaves leaves;
  CHECK_FALSE(enumerator.next(leaves));
  CHECK(enumerator.is_given_up());
}

TEST_CASE("random trees: one by one is all at once, in the same order") {
  std::mt19937 random(11);
  std::size_t many = 0;
  for (int round = 0; round < 2000; ++round) {
    InteractionTree tree;
    (void)add_random(tree, random, 4);
    const std::vector<Leaves> expected = listed(tree, 0);
    if (expected.size() > 3000) continue;
    many += expected.size() > 4 ? 1 : 0;
    auto all = list_interactions(tree, 0, expected.size());
    REQUIRE(all);
    CHECK(*all == expected);
    if (!expected.empty()) CHECK_FALSE(list_interactions(tree, 0, expected.size() - 1));
  }
  CHECK(many > 100);
}
