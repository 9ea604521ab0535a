// Strong components, cycles and topological orders, by hand and against reachability on random graphs.
#include "compiler/analysis/graph_algorithms.hpp"

#include <catch2/catch.hpp>
#include <random>

namespace {

using u32 = std::uint32_t;
using Edges = std::vector<std::vector<u32>>;

struct Recorder {
  const Edges& edges;
  std::vector<std::vector<u32>> components;
  std::vector<std::pair<u32, u32>> reached;

  std::size_t enter(u32) { return 0; }
  u32 next(u32 node, std::size_t& at) { return at == edges[node].size() ? bip::kNoSuccessor : edges[node][at++]; }
  void reach(u32 from, u32 to) { reached.emplace_back(from, to); }
  void close(const u32* nodes, std::size_t count) { components.emplace_back(nodes, nodes + count); }
};

std::vector<std::vector<u32>> components_of(const Edges& edges, bip::StrongComponents<std::size_t>& search) {
  Recorder recorder{edges, {}, {}};
  search.begin(edges.size());
  for (u32 start = 0; start < edges.size(); ++start) search.visit(start, recorder);
  return recorder.components;
}

std::vector<u32> cycle_of(const Edges& edges) {
  std::vector<u32> nodes;
  const auto enter = [](u32) { return std::size_t{0}; };
  const auto next = [&](u32 node, std::size_t& at) {
    return at == edges[node].size() ? bip::kNoSuccessor : edges[node][at++];
  };
  for (const auto& on : bip::find_cycle(static_cast<u32>(edges.size()), enter, next, [](u32, u32) { return true; }))
    nodes.push_back(on.node);
  return nodes;
}

bool order_of(const Edges& edges, std::vector<u32>& order, std::vector<u32>& missing) {
  missing.assign(edges.size(), 0);
  for (const std::vector<u32>& successors : edges) {
    for (u32 to : successors) ++missing[to];
  }
  return bip::topological_order(missing, order, [&](u32 node, const auto& see) {
    for (u32 to : edges[node]) see(to);
  });
}

// By node and node: is there a path of at least one edge?
std::vector<std::vector<bool>> closure(const Edges& edges) {
  const std::size_t count = edges.size();
  std::vector<std::vector<bool>> reaches(count, std::vector<bool>(count, false));
  for (std::size_t a = 0; a < count; ++a) {
    for (u32 to : edges[a]) reaches[a][to] = true;
  }
  for (std::size_t via = 0; via < count; ++via) {
    for (std::size_t a = 0; a < count; ++a) {
      for (std::size_t b = 0; b < count; ++b) reaches[a][b] = reaches[a][b] || (reaches[a][via] && reaches[via][b]);
    }
  }
  return reaches;
}

}  // namespace

TEST_CASE("strong components are closed after those that they reach") {
  // 0 <-> 1 -> 2 <-> 3, 4 alone, 5 with an edge to itself.
  const Edges edges{{1}, {0, 2}, {3}, {2}, {}, {5}};
  bip::StrongComponents<std::size_t> search;
  CHECK(components_of(edges, search) == std::vector<std::vector<u32>>{{2, 3}, {0, 1}, {4}, {5}});
  // The same object again, and for a smaller graph: nothing is left of the search before.
  CHECK(components_of({{1}, {}}, search) == std::vector<std::vector<u32>>{{1}, {0}});
}

TEST_CASE("a search from one node leaves the rest unvisited") {
  const Edges edges{{1}, {}, {0}};
  Recorder recorder{edges, {}, {}};
  bip::StrongComponents<std::size_t> search;
  search.begin(edges.size());
  search.visit(0, recorder);
  CHECK(search.is_visited(1));
  CHECK_FALSE(search.is_open(1));
  CHECK_FALSE(search.is_visited(2));
  search.visit(2, recorder);
  CHECK(recorder.components == std::vector<std::vector<u32>>{{1}, {0}, {2}});
  CHECK(recorder.reached == std::vector<std::pair<u32, u32>>{{0, 1}, {2, 0}});
}

TEST_CASE("a path of a million nodes needs no stack") {
  constexpr u32 kNodes = 1000000;
  Edges edges(kNodes);
  for (u32 node = 0; node + 1 < kNodes; ++node) edges[node].push_back(node + 1);
  bip::StrongComponents<std::size_t> search;
  CHECK(components_of(edges, search).size() == kNodes);
  CHECK(cycle_of(edges).empty());
  edges[kNodes - 1].push_back(0);
  CHECK(components_of(edges, search).size() == 1);
  CHECK(cycle_of(edges).size() == kNodes);
}

TEST_CASE("the first cycle of a depth-first search") {
  CHECK(cycle_of({{1}, {2}, {3}, {1}}) == std::vector<u32>{1, 2, 3});
  CHECK(cycle_of({{}, {1}}) == std::vector<u32>{1});
  CHECK(cycle_of({{1, 2}, {3}, {3}, {}}).empty());
}

TEST_CASE("edges that may be costly are looked at only if they may close a cycle") {
  const Edges edges{{1, 2}, {2}, {}};
  std::vector<std::pair<u32, u32>> asked;
  const auto enter = [](u32) { return std::size_t{0}; };
  const auto next = [&](u32 node, std::size_t& at) {
    return at == edges[node].size() ? bip::kNoSuccessor : edges[node][at++];
  };
  const auto is_edge = [&](u32 from, u32 to) {
    asked.emplace_back(from, to);
    return true;
  };
  CHECK(bip::find_cycle(3, enter, next, is_edge).empty());
  CHECK(asked == std::vector<std::pair<u32, u32>>{{0, 1}, {1, 2}});
}

TEST_CASE("a topological order, and what lies on a cycle or behind one") {
  std::vector<u32> order, missing;
  CHECK(order_of({{2}, {2}, {3}, {}}, order, missing));
  CHECK(order == std::vector<u32>{0, 1, 2, 3});
  CHECK_FALSE(order_of({{1}, {2}, {1, 3}, {}}, order, missing));
  CHECK(order == std::vector<u32>{0});
  CHECK(missing == std::vector<u32>{0, 1, 1, 1});
}

TEST_CASE("random graphs: components, cycles and orders agree with reachability") {
  std::mt19937 random(7);
  std::size_t cyclic = 0;
  bip::StrongComponents<std::size_t> search;
  for (int round = 0; round < 300; ++round) {
    const u32 count = 1 + static_cast<u32>(random() % 12);
    Edges edges(count);
    for (u32 k = static_cast<u32>(random() % (count + count / 2 + 1)); k > 0; --k)
      edges[random() % count].push_back(static_cast<u32>(random() % count));
    const std::vector<std::vector<bool>> reaches = closure(edges);
    const std::vector<std::vector<u32>> components = components_of(edges, search);
    std::vector<std::size_t> of(count, 0);
    std::size_t total = 0;
    for (std::size_t k = 0; k < components.size(); ++k) {
      for (u32 node : components[k]) of[node] = k;
      total += components[k].size();
    }
    REQUIRE(total == count);
    bool has_cycle = false;
    for (u32 a = 0; a < count; ++a) {
      has_cycle = has_cycle || reaches[a][a];
      for (u32 b = 0; b < count; ++b) {
        CHECK((of[a] == of[b]) == (a == b || (reaches[a][b] && reaches[b][a])));
        if (reaches[a][b]) CHECK(of[b] <= of[a]);
      }
    }
    cyclic += has_cycle ? 1 : 0;
    const std::vector<u32> cycle = cycle_of(edges);
    CHECK(cycle.empty() != has_cycle);
    for (std::size_t k = 0; k < cycle.size(); ++k) {
      const std::vector<u32>& successors = edges[cycle[k]];
      CHECK(std::count(successors.begin(), successors.end(), cycle[(k + 1) % cycle.size()]) != 0);
    }
    std::vector<u32> order, missing;
    CHECK(order_of(edges, order, missing) != has_cycle);
    std::vector<std::size_t> position(count, count);
    for (std::size_t k = 0; k < order.size(); ++k) position[order[k]] = k;
    for (u32 a = 0; a < count; ++a) {
      for (u32 b : edges[a]) CHECK((position[a] < position[b] || position[b] == count));
    }
  }
  CHECK(cyclic > 50);
  CHECK(cyclic < 250);
}
