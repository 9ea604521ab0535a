// Algorithms over directed graphs whose nodes are 0 … n-1: strongly connected components, a cycle, a topological order.
//
// One implementation for the compiler and the runtime. All of it is iterative, because
// the graphs come from users' models. A graph is not built: the caller enumerates the successors of a node when the
// search asks for them. Cost: one step per node and per edge that is enumerated; memory 16 bytes a node and one frame
// per node on the path.
// Robert Tarjan: Depth-First Search and Linear Graph Algorithms (1972); Arthur Kahn: Topological Sorting of Large
// Networks (1962).
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "runtime/include/bip/assert.hpp"

namespace bip {

/// No node: the end of an enumeration of successors.
inline constexpr std::uint32_t kNoSuccessor = 0xffffffffu;

/// Strongly connected components by Tarjan's algorithm, from one start node after the other.
///
/// `Cursor` is a position in the enumeration of a node's successors. A visitor has
///   Cursor enter(node)               called once per node, when the search reaches it first
///   node next(node, Cursor&)         the next successor, kNoSuccessor at the end
///   void reach(from, to)             an edge to a node that the search has left; may be empty
///   void close(const node*, count)   a component is complete, its first node is the root
/// Components are closed in reverse topological order: all that a component reaches were closed before it. The object
/// keeps its memory between searches.
template <class Cursor>
class StrongComponents {
 public:
  /// Forgets the previous search. Nodes are below `nodes`. O(1) if there are no more nodes than before.
  void begin(std::size_t nodes) {
    visits_.resize(nodes);
    if (++round_ == 0) {
      visits_.assign(nodes, {});
      round_ = 1;
    }
    order_ = 0;
    frames_.clear();
    open_.clear();
  }
  [[nodiscard]] bool is_visited(std::uint32_t node) const { return visits_[node].round == round_; }
  /// Is the node visited and its component not complete?
  [[nodiscard]] bool is_open(std::uint32_t node) const { return is_visited(node) && visits_[node].is_open; }

  /// Visits all that `start` reaches and that was not visited since begin().
  template <class Visitor>
  void visit(std::uint32_t start, Visitor&& visitor) {
    if (is_visited(start)) return;
    enter(start, visitor);
    while (!frames_.empty()) {
      const std::uint32_t node = frames_.back().node;
      const std::uint32_t to = visitor.next(node, frames_.back().cursor);
      if (to == kNoSuccessor) {
        leave(node, visitor);
      } else if (!is_visited(to)) {
        enter(to, visitor);
      } else if (visits_[to].is_open) {
        visits_[node].low = std::min(visits_[node].low, visits_[to].order);
      } else {
        visitor.reach(node, to);
      }
    }
  }

 private:
  // `order` numbers the nodes as they are met; `low` is Tarjan's lowlink: the least order in the component that is
  // known to be reachable from the node.
  struct Visit {
    std::uint32_t round = 0, order = 0, low = 0;
    bool is_open = false;
  };
  struct Frame {
    std::uint32_t node;
    Cursor cursor;
  };

  template <class Visitor>
  void enter(std::uint32_t node, Visitor& visitor) {
    BIP_ASSERT(node < visits_.size(), "node {} of {}", node, visits_.size());
    visits_[node] = {round_, order_, order_, true};
    ++order_;
    open_.push_back(node);
    frames_.push_back({node, visitor.enter(node)});
  }
  template <class Visitor>
  void leave(std::uint32_t node, Visitor& visitor) {
    frames_.pop_back();
    // A node that reaches no earlier open node is the root of a component: all from it to the top of the stack.
    if (visits_[node].low == visits_[node].order) {
      std::size_t first = open_.size();
      do visits_[open_[--first]].is_open = false;
      while (open_[first] != node);
      visitor.close(open_.data() + first, open_.size() - first);
      open_.resize(first);
    }
    if (frames_.empty()) {
      BIP_ASSERT(open_.empty(), "{} nodes are in no component", open_.size());
      return;
    }
    const std::uint32_t above = frames_.back().node;
    if (visits_[node].is_open) visits_[above].low = std::min(visits_[above].low, visits_[node].low);
    visitor.reach(above, node);
  }

  std::vector<Visit> visits_;  // by node
  std::vector<Frame> frames_;  // the path from the start
  std::vector<std::uint32_t> open_;
  std::uint32_t round_ = 0, order_ = 0;
};

/// A node on a path with the position behind the edge that the path takes.
template <class Cursor>
struct PathNode {
  std::uint32_t node;
  Cursor cursor;
};

/// Returns the nodes of the first cycle that a depth-first search from the nodes 0 … nodes-1 meets, in their order: the
/// edge of the last one leads to the first; empty if there is no cycle. `enter(node)` returns a cursor at the node's
/// first candidate, `next(node, Cursor&)` the next candidate, kNoSuccessor at the end, `is_edge(from, to)` whether a
/// candidate is a successor: it may be costly, and is called only for candidates that might close a cycle.
template <class Enter, class Next, class IsEdge>
[[nodiscard]] auto find_cycle(std::uint32_t nodes, const Enter& enter_node, const Next& next, const IsEdge& is_edge) {
  using Path = std::vector<PathNode<decltype(enter_node(nodes))>>;
  enum class State : std::uint8_t { New, Open, Done };
  std::vector<State> states(nodes, State::New);
  Path path;
  const auto enter = [&](std::uint32_t node) {
    states[node] = State::Open;
    path.push_back({node, enter_node(node)});
  };
  for (std::uint32_t start = 0; start < nodes; ++start) {
    if (states[start] == State::New) enter(start);
    while (!path.empty()) {
      const std::uint32_t node = path.back().node;
      const std::uint32_t to = next(node, path.back().cursor);
      BIP_ASSERT(to == kNoSuccessor || to < nodes, "successor {} of {} nodes", to, nodes);
      if (to == kNoSuccessor) {
        states[node] = State::Done;
        path.pop_back();
      } else if (states[to] == State::Done || !is_edge(node, to)) {
        continue;
      } else if (states[to] == State::New) {
        enter(to);
      } else {
        const auto first = std::find_if(path.begin(), path.end(), [to](const auto& on) { return on.node == to; });
        path.erase(path.begin(), first);
        return path;
      }
    }
  }
  return Path{};
}

/// The main step of Kahn's algorithm: appends to `order`, which has the nodes without predecessor, each node whose
/// predecessors are all in it. `missing`: by node, the number of predecessors; it becomes the number of those that are
/// not in the order. each_next: as below.
template <class EachNext>
void extend_topological_order(std::vector<std::uint32_t>& missing, std::vector<std::uint32_t>& order,
                              EachNext&& each_next) {
  for (std::size_t at = 0; at < order.size(); ++at) {
    each_next(order[at], [&](std::uint32_t next) {
      BIP_ASSERT(missing[next] != 0, "node {} has more predecessors than were counted", next);
      if (--missing[next] == 0) order.push_back(next);
    });
  }
}

/// Orders nodes so that each comes after its predecessors, by Kahn's algorithm; nodes that become ready at the same
/// time come in the order of the enumeration. `missing` has the number of predecessors of each node, a pair as often as
/// `each_next(node, see)` calls see(successor) for it; it becomes the number of those that are not in the order.
/// Returns whether all nodes are in the order: those that are not lie on a cycle or behind one.
template <class EachNext>
bool topological_order(std::vector<std::uint32_t>& missing, std::vector<std::uint32_t>& order, EachNext&& each_next) {
  order.clear();
  for (std::uint32_t node = 0; node < missing.size(); ++node) {
    if (missing[node] == 0) order.push_back(node);
  }
  extend_topological_order(missing, order, each_next);
  return order.size() == missing.size();
}

}  // namespace bip
