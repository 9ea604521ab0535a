// The graph of a system's connectors: leaves, groups, shared nodes, and a leaf for each distinguished use of a port.
#include "compiler/analysis/connector_graph.hpp"

#include <catch2/catch.hpp>

#include "tests/unit/system/instantiated.hpp"

namespace {

using namespace bip::analysis;
using NodeKind = ConnectorNodeKind;

std::vector<u32> children_of(const ConnectorGraph& graph, u32 node) {
  std::vector<u32> out;
  for (const ConnectorGraph::Edge& edge : graph.children(node)) out.push_back(edge.node);
  return out;
}

u32 root_of(const bip::System& system, const ConnectorGraph& graph, const std::string& path) {
  for (std::size_t row = 0; row < system.connectors.size(); ++row) {
    if (system.connectors[bip::ConnectorId(row)].path == path) return graph.root_of[row];
  }
  FAIL("no connector " << path);
  return 0;
}

}  // namespace

TEST_CASE("two users of an inner connector share its node") {
  const bip::test::Instantiated t(bip::test::with_types(R"(
compound type R()
  component A a(1), b(2), c(3)
  connector Maybe inner(a.p, b.p)
  connector Two one(inner.x, c.p)
  connector Two other(inner.x, c.q)
end)"));
  INFO(t.codes());
  REQUIRE(t.system);
  const ConnectorGraph graph = build_connector_graph(*t.system);
  CHECK(graph.port_base == std::vector<u32>{0, 2, 4, 6});
  CHECK(graph.port_count() == 6);
  CHECK(graph.atom_of_port == std::vector<u32>{0, 0, 1, 1, 2, 2});
  REQUIRE(graph.nodes.size() == 9);
  const u32 inner = root_of(*t.system, graph, "ROOT.inner");
  CHECK(graph.nodes[inner].kind == NodeKind::Trigger);
  CHECK_FALSE(graph.nodes[inner].is_root);
  CHECK(children_of(graph, inner) == std::vector<u32>{0, 2});
  CHECK(graph.children(inner)[0].is_trigger);
  CHECK_FALSE(graph.children(inner)[1].is_trigger);
  CHECK(graph.parents(inner).size() == 2);
  const u32 one = root_of(*t.system, graph, "ROOT.one");
  CHECK(graph.nodes[one].kind == NodeKind::All);
  CHECK(graph.nodes[one].is_root);
  CHECK(children_of(graph, one) == std::vector<u32>{inner, 4});
  CHECK(graph.parents(1).empty());
  // Children come before their parents, and each edge is there from both ends.
  std::size_t edges = 0;
  for (u32 row = 0; row < graph.nodes.size(); ++row) {
    for (u32 child : children_of(graph, row)) {
      CHECK(child < row);
      std::size_t found = 0;
      for (const ConnectorGraph::Edge& up : graph.parents(child)) found += up.node == row ? 1 : 0;
      CHECK(found == 1);
      ++edges;
    }
  }
  CHECK(edges == 6);
}

TEST_CASE("a connector of one port has a group of its own") {
  const bip::test::Instantiated t(
      bip::test::with_types("compound type R()\n  component A a(1)\n  connector One k(a.q)\nend"));
  INFO(t.codes());
  REQUIRE(t.system);
  const ConnectorGraph graph = build_connector_graph(*t.system);
  REQUIRE(graph.nodes.size() == 3);
  CHECK(graph.nodes[2].kind == NodeKind::All);
  CHECK(graph.nodes[2].connector == 0);
  CHECK(children_of(graph, 2) == std::vector<u32>{1});
}

TEST_CASE("distinguished uses of a port have leaves after those of the ports") {
  const bip::test::Instantiated t(bip::test::with_types(R"(
compound type R()
  component A a(1), b(2)
  connector Two one(a.p, b.p)
  connector Two other(a.p, b.q)
end)"));
  INFO(t.codes());
  REQUIRE(t.system);
  ConnectorLeaves leaves;
  leaves.of_atom = {4, 2};
  leaves.of_param = [](bip::ConnectorId connector, u32 param) {
    return param == 0 ? 2 + connector.value : connector.value;
  };
  const ConnectorGraph graph = build_connector_graph(*t.system, leaves);
  CHECK(graph.port_base == std::vector<u32>{0, 4, 6});
  CHECK(children_of(graph, graph.root_of[0]) == std::vector<u32>{2, 4});
  CHECK(children_of(graph, graph.root_of[1]) == std::vector<u32>{3, 5});
}
