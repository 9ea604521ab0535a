// See step_equations.hpp.
#include "compiler/verify/invariants/step_equations.hpp"

#include <algorithm>

namespace bip::verify {

void add_step_equations(const Net& net, const ModeReachability& reachable, SparseSystem& system,
                        std::vector<SparseSystem::Row>& equations, const OwnChanges& own) {
  using Row = SparseSystem::Row;
  std::vector<Row> change(net.graph.nodes.size());
  std::vector<std::uint8_t> is_dead(net.graph.nodes.size(), 0);
  for (u32 row = 0; row < net.graph.nodes.size() && !system.is_given_up(); ++row) {
    const Node& node = net.graph.nodes[row];
    if (node.kind == ConnectorNodeKind::Port) {
      const u32 base = net.mode_base[net.graph.atom_of_port[row]];
      const auto moves = net.moves(row);
      is_dead[row] = !reachable.in_context(row) || std::none_of(moves.begin(), moves.end(), [&](const Move& move) {
        return reachable.is_on(base + move.from);
      });
      change[row] = {{row, 1}};
    } else {
      std::vector<u32> live;
      for (const Edge& child : net.graph.children(row)) {
        if (is_dead[child.node] == 0) live.push_back(child.node);
        else if (node.kind == ConnectorNodeKind::All) is_dead[row] = 1;
      }
      if (live.empty()) is_dead[row] = 1;
      if (is_dead[row] != 0) continue;
      if (node.kind == ConnectorNodeKind::All) {
        for (u32 child : live) change[row] = system.combined(change[row], 1, change[child], 1);
        const std::vector<Row> alternatives = own ? own(row) : std::vector<Row>();
        for (std::size_t k = 1; k < alternatives.size(); ++k)
          equations.push_back(system.combined(alternatives[k], 1, alternatives[0], -1));
        if (!alternatives.empty()) change[row] = system.combined(change[row], 1, alternatives[0], 1);
      } else if (node.kind == ConnectorNodeKind::Trigger && live.size() > 1) {
        for (u32 child : live) equations.push_back(change[child]);
      } else {
        change[row] = change[live[0]];
        for (std::size_t k = 1; k < live.size(); ++k)
          equations.push_back(system.combined(change[live[k]], 1, change[live[0]], -1));
      }
    }
    if (node.is_root && is_dead[row] == 0) equations.push_back(change[row]);
  }
}

}  // namespace bip::verify
