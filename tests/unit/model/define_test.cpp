// The algebra of `define` trees: what bip::model answers without listing interactions, against lists of all of them.
#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <set>

#include "compiler/model/model.hpp"

namespace {

using bip::ConnectorType;
using bip::DefineNode;
using Params = std::vector<std::uint32_t>;
using Interactions = std::set<std::set<std::uint32_t>>;

struct RandomTree {
  std::mt19937 random;
  ConnectorType type{};

  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); }

  // A node in preorder; a group has one child or more.
  std::uint32_t node(int depth) {
    const auto row = static_cast<std::uint32_t>(type.define.size());
    type.define.emplace_back();
    type.define[row].trigger = below(3) == 0;
    if (row != 0 && (depth == 0 || below(2) == 0)) {
      type.define[row].is_leaf = true;
      type.define[row].param = static_cast<std::uint32_t>(type.params.size());
      type.params.emplace_back();
      return row;
    }
    const std::uint32_t n = 1 + below(3);
    for (std::uint32_t k = 0; k < n; ++k) {
      const std::uint32_t child = node(depth - 1);
      type.define[row].children.push_back(child);
    }
    return row;
  }
};

// The definition: a rendezvous joins one choice of every child, a weak synchronisation one of each child of a set with
// a trigger in it.
Interactions list(const ConnectorType& type, std::uint32_t row) {
  const DefineNode& node = type.define[row];
  if (node.is_leaf) return {{node.param}};
  const bool weak =
      std::any_of(node.children.begin(), node.children.end(), [&](std::uint32_t c) { return type.define[c].trigger; });
  Interactions all;
  for (std::uint32_t mask = 1; mask < 1u << node.children.size(); ++mask) {
    bool has_trigger = false;
    Interactions joined = {{}};
    for (std::size_t k = 0; k < node.children.size(); ++k) {
      if ((mask >> k & 1u) == 0) continue;
      has_trigger |= type.define[node.children[k]].trigger;
      Interactions next;
      for (const auto& left : joined) {
        for (std::set<std::uint32_t> right : list(type, node.children[k])) {
          right.insert(left.begin(), left.end());
          next.insert(std::move(right));
        }
      }
      joined = std::move(next);
    }
    if (weak ? has_trigger : mask + 1 == 1u << node.children.size()) all.insert(joined.begin(), joined.end());
  }
  return all;
}

TEST_CASE("what define gives, against the list of all interactions") {
  std::size_t seen = 0;
  for (std::uint32_t seed = 0; seed < 600; ++seed) {
    RandomTree tree{std::mt19937(seed)};
    tree.node(3);
    const ConnectorType& type = tree.type;
    const auto n = static_cast<std::uint32_t>(type.params.size());
    if (n > 8) continue;
    const Interactions all = list(type, 0);
    INFO("seed " << seed << ", " << n << " parameters");
    for (std::uint32_t mask = 0; mask < 1u << n; ++mask) {
      Params within;
      for (std::uint32_t p = 0; p < n; ++p) {
        if ((mask >> p & 1u) != 0) within.push_back(p);
      }
      const std::set<std::uint32_t> set(within.begin(), within.end());
      REQUIRE(bip::model::is_interaction(type, within) == all.contains(set));
      const Params largest = bip::model::largest_interaction(type, within);
      const std::set<std::uint32_t> best(largest.begin(), largest.end());
      bool is_largest = std::is_sorted(largest.begin(), largest.end()) && (largest.empty() || all.contains(best)) &&
                        std::includes(set.begin(), set.end(), best.begin(), best.end());
      for (const auto& one : all) {
        // Every interaction within `within` is within the largest: there is one largest.
        const bool fits = std::includes(set.begin(), set.end(), one.begin(), one.end());
        is_largest = is_largest && (!fits || std::includes(best.begin(), best.end(), one.begin(), one.end()));
        ++seen;
      }
      REQUIRE(is_largest);
    }
  }
  REQUIRE(seen > 10000);
}

TEST_CASE("a connector without a define has no interaction") {
  const ConnectorType type{};
  REQUIRE(bip::model::largest_interaction(type, {0, 1}).empty());
  REQUIRE_FALSE(bip::model::is_interaction(type, {}));
}

}  // namespace
