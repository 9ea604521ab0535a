// Linking: groups of the availability network that only one other node counts go into that node, where that says the
// same. See tables.hpp.
//
// A rendezvous of rendezvous is one counter of ports: a port that becomes enabled then moves the interaction's counter
// itself, where it went up from group to group before. A node of n children either needs all of them (its value starts
// at -n) or one (it starts at -1). A group g goes into the node p that counts it
//   - if both need all, or both need one: p counts g's children in its place;
//   - if g has one child, or p counts g alone: one of the two says nothing of its own.
// Nodes that connectors with triggers look at (PlanChoice) stay. Cost: linear in the network.
#include <numeric>

#include "bip/assert.hpp"
#include "runtime/core/link/tables.hpp"

namespace bip::rt {

namespace {

class Contraction {
 public:
  Contraction(Tables& tables, NetworkEdges& edges) : tables_(tables), edges_(edges) {
    const std::size_t nodes = tables.node_count();
    starts_.reserve(nodes);
    for (const InteractionId interaction : tables.interactions.ids()) starts_.push_back(tables.start_of(interaction));
    starts_.insert(starts_.end(), tables.inner_start.begin(), tables.inner_start.end());
    counted_by_.assign(nodes, kNone);
    children_.assign(nodes, 0);
    into_.resize(nodes);
    std::iota(into_.begin(), into_.end(), 0u);
    for (const Csr::Pair& edge : edges.from_ports) ++children_[edge.to];
    for (const Csr::Pair& edge : edges.from_nodes) {
      ++children_[edge.to];
      counted_by_[edge.from] = counted_by_[edge.from] == kNone ? edge.to : kMany;
    }
    for (const PlanChoice& choice : tables.plan_choices) {
      if (choice.kind == PlanChoice::Kind::Group) counted_by_[choice.ref] = kMany;
    }
  }

  void run() {
    const u32 interactions = static_cast<u32>(tables_.interactions.size());
    for (u32 group = interactions; group < into_.size(); ++group) {
      if (counted_by_[group] != kNone && counted_by_[group] != kMany) contract(group, find(counted_by_[group]));
    }
    std::erase_if(edges_.from_nodes, [&](const Csr::Pair& edge) { return into_[edge.from] != edge.from; });
    for (std::vector<Csr::Pair>* edges : {&edges_.from_ports, &edges_.from_nodes}) {
      for (Csr::Pair& edge : *edges) edge.to = find(edge.to);
    }
    tables_.interaction_start.assign(starts_.begin(), starts_.begin() + interactions);
    tables_.inner_start.assign(starts_.begin() + interactions, starts_.end());
  }

 private:
  static constexpr u32 kMany = kNone - 1;

  [[nodiscard]] bool needs_all(u32 node) const { return starts_[node] == -static_cast<std::int32_t>(children_[node]); }
  [[nodiscard]] bool needs_one(u32 node) const { return starts_[node] == -1; }

  // Which node the node has gone into.
  u32 find(u32 node) {
    u32 end = node;
    while (into_[end] != end) end = into_[end];
    while (into_[node] != end) {
      const u32 next = into_[node];
      into_[node] = end;
      node = next;
    }
    return end;
  }

  void contract(u32 group, u32 above) {
    BIP_ASSERT(group != above && starts_[group] < 0 && starts_[above] < 0, "group {} is counted by {}", group, above);
    if (children_[group] == 0) return;
    const bool all = needs_all(group) && needs_all(above);
    // The only child of `above`, or with one child of its own: `above` stays as it is, or becomes what the group is.
    const bool one = needs_one(group) && (needs_one(above) || children_[group] == 1);
    if (!all && !one) return;
    if (all) starts_[above] += starts_[group] + 1;
    children_[above] += children_[group] - 1;
    into_[group] = above;
  }

  Tables& tables_;
  NetworkEdges& edges_;
  std::vector<std::int32_t> starts_;  // by node
  std::vector<u32> counted_by_;       // by node: kNone, a node, or kMany
  std::vector<u32> children_;         // by node
  std::vector<u32> into_;             // by node: itself, or a node that it has gone into
};

}  // namespace

void contract_network(Tables& tables, NetworkEdges& edges) {
  if (!edges.from_nodes.empty()) Contraction(tables, edges).run();
}

}  // namespace bip::rt
