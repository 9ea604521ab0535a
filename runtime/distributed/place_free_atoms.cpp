// See place_free_atoms.hpp.
#include "runtime/distributed/place_free_atoms.hpp"

#include <algorithm>
#include <queue>

#include "bip/assert.hpp"
#include "runtime/core/fire/partial.hpp"

namespace bip::rt {

namespace {

constexpr u32 kMostPins = 1000;  // of an edge: larger ones are cut whatever is done
constexpr u64 kCounted = 64;     // the weight of a step that was taken; each interaction has 1 besides
constexpr std::size_t kMostPasses = 16;
constexpr std::size_t kMostVain = 500;  // moves of a pass after its best state
constexpr u32 kFirstCuts = 8;           // that are improved
constexpr u32 kManyVertices = 20000;    // of so many only two first cuts are improved

class AtomPlacer {
 public:
  AtomPlacer(const Tables& tables, const std::vector<u64>& counts, const std::vector<u32>& together,
             Placement& placement)
      : placement_(placement), nodes_(static_cast<u32>(placement.nodes.size())) {
    const u32 atoms = tables.image->atoms.size;
    vertex_of_.assign(atoms, kNone);
    for (u32 atom = 0; atom < atoms; ++atom) {
      u32& vertex = vertex_of_[together[atom]];
      if (vertex == kNone) {
        vertex = static_cast<u32>(size_.size());
        size_.push_back(0);
        home_.push_back(kNone);
      }
      vertex_of_[atom] = vertex;
      ++size_[vertex];
      if (home_[vertex] == kNone) home_[vertex] = placement.home[atom];
    }
    for (const u32 home : home_) is_fixed_.push_back(home != kNone);
    std::vector<Csr::Pair> pins;
    std::vector<u32> ports;
    for (const InteractionId interaction : tables.interactions.ids()) {
      ports_of_interaction(tables, tables.interactions[interaction], ports);
      for (u32& port : ports) port = vertex_of_[tables.port_atom[port]];
      std::sort(ports.begin(), ports.end());
      ports.erase(std::unique(ports.begin(), ports.end()), ports.end());
      if (ports.size() < 2 || ports.size() > kMostPins) continue;
      for (const u32 vertex : ports) pins.push_back({static_cast<u32>(weight_.size()), vertex});
      weight_.push_back(1 + (counts.empty() ? 0 : counts[interaction.value] * kCounted));
    }
    pins_ = Csr::build(weight_.size(), pins);
    edges_ = pins_.transposed(static_cast<u32>(size_.size()));
    for (u32 vertex = 0; vertex < size_.size(); ++vertex) {
      i64& total = total_.emplace_back(0);
      for (const u32 edge : edges_[vertex]) total += static_cast<i64>(weight_[edge]);
    }
    load_.assign(nodes_, 0);
    const u64 share = (u64{atoms} + nodes_ - 1) / nodes_;
    // One more at least: in full nodes nothing moves.
    most_ = share + std::max<u64>(1, share / 10);
    least_ = find_least();
    score_.assign(nodes_, 0);
  }

  void place() {
    const std::vector<u32> given = home_;
    std::vector<u32> best;
    u64 least = 0;
    const u32 cuts = size_.size() < kManyVertices ? kFirstCuts : 2;
    for (u32 cut = 0; cut < cuts; ++cut) {
      home_ = given;
      std::fill(load_.begin(), load_.end(), 0);
      for (u32 vertex = 0; vertex < size_.size(); ++vertex) {
        if (home_[vertex] != kNone) load_[home_[vertex]] += size_[vertex];
      }
      if (cut == 0) grow();
      else grow_pieces(static_cast<u32>(u64{cut - 1} * size_.size() / (cuts - 1)));
      fill_nodes();
      for (std::size_t pass = 0; pass < kMostPasses && improve(); ++pass) {
      }
      if (const u64 now = cost(); best.empty() || now < least) {
        least = now;
        best = home_;
      }
    }
    home_ = std::move(best);
    for (u32 atom = 0; atom < vertex_of_.size(); ++atom) {
      if (placement_.home[atom] == kNone) placement_.home[atom] = home_[vertex_of_[atom]];
    }
  }

 private:
  struct Move {
    i64 gain = 0;
    u32 vertex = 0, to = 0;
    // The queue has the largest gain on top, of equal ones the smaller vertex.
    bool operator<(const Move& other) const { return gain != other.gain ? gain < other.gain : vertex > other.vertex; }
  };

  // Half of the level to which atoms without a home fill the nodes, the emptiest first; one at least if they reach all.
  [[nodiscard]] u64 find_least() const {
    std::vector<u64> loads(nodes_, 0);  // of atoms that have a home
    u64 free = 0;
    for (u32 vertex = 0; vertex < size_.size(); ++vertex) {
      if (home_[vertex] == kNone) free += size_[vertex];
      else loads[home_[vertex]] += size_[vertex];
    }
    std::sort(loads.begin(), loads.end());
    u64 level = 0, sum = free;
    for (u32 node = 0; node < nodes_; ++node) {
      sum += loads[node];
      level = sum / (node + 1);
      // Atoms do not suffice to lift the nodes so far above the load of the next.
      if (node + 1 < nodes_ && level < loads[node + 1]) break;
    }
    return level == 0 ? 0 : std::max<u64>(1, level / 2);
  }

  // Breadth first: those with a home, then a vertex of each piece. A vertex goes where its edges are, if there is room.
  void grow() {
    std::vector<u32> order;
    std::vector<bool> is_met(size_.size(), false);
    const auto walk = [&](std::size_t at) {
      for (; at < order.size(); ++at) {
        for (const u32 edge : edges_[order[at]]) {
          for (const u32 next : pins_[edge]) {
            if (is_met[next]) continue;
            is_met[next] = true;
            order.push_back(next);
          }
        }
      }
    };
    for (u32 vertex = 0; vertex < size_.size(); ++vertex) {
      if (!is_fixed_[vertex]) continue;
      is_met[vertex] = true;
      order.push_back(vertex);
    }
    const bool is_free = order.empty();
    walk(0);
    for (u32 vertex = 0; vertex < size_.size(); ++vertex) {
      if (is_met[vertex]) continue;
      is_met[vertex] = true;
      order.push_back(vertex);
      walk(order.size() - 1);
    }
    // Without any home: pieces of equal size.
    u64 passed = 0;
    for (const u32 vertex : order) {
      if (is_free) {
        move(vertex, static_cast<u32>(passed * nodes_ / vertex_of_.size()));
        passed += size_[vertex];
      } else if (home_[vertex] == kNone) {
        move(vertex, best_home(vertex));
      }
    }
  }

  // One piece after the other, each around what has a home there, or a vertex beside the pieces before: the vertex next
  // that cuts least (graph growing, Karypis, Kumar, "A fast and high quality multilevel scheme for partitioning
  // irregular graphs", SIAM J. Sci. Comput. 20(1), 1998, section 4.2). The first piece begins far away from `start`.
  void grow_pieces(u32 start) {
    u64 left = 0;  // atoms without a home
    for (u32 vertex = 0; vertex < size_.size(); ++vertex) left += home_[vertex] == kNone ? size_[vertex] : 0;
    std::vector<u32> degree(size_.size(), 0);  // by vertex: edges that some piece has
    std::vector<bool> is_cut(weight_.size(), false);
    const auto mark = [&](u32 vertex) {
      for (const u32 edge : edges_[vertex]) {
        if (is_cut[edge]) continue;
        is_cut[edge] = true;
        for (const u32 pin : pins_[edge]) ++degree[pin];
      }
    };
    u32 next = farthest(start);
    for (u32 node = 0; node < nodes_ && left != 0; ++node) {
      // What is left is shared by this node and those after it.
      u64 loads = left;
      for (u32 later = node; later < nodes_; ++later) loads += load_[later];
      const u64 share = (loads + nodes_ - node - 1) / (nodes_ - node);
      if (share > load_[node]) left -= grow_piece(node, share - load_[node], next, mark);
      next = kNone;
      for (u32 vertex = 0; vertex < size_.size(); ++vertex) {
        if (home_[vertex] == kNone && (next == kNone || degree[vertex] > degree[next])) next = vertex;
      }
    }
    for (u32 vertex = 0; vertex < size_.size(); ++vertex) {
      if (home_[vertex] == kNone) move(vertex, best_home(vertex));
    }
  }

  // Puts at most so many atoms on the node; returns how many.
  template <class Mark>
  u64 grow_piece(u32 node, u64 room, u32 start, Mark mark) {
    std::vector<i64> inside(size_.size(), 0);  // by vertex: weight of its edges that the piece has
    std::vector<bool> is_in(weight_.size(), false);
    std::priority_queue<Move> queue;
    // What more of its edges the piece has than others.
    const auto gain = [&](u32 vertex) { return 2 * inside[vertex] - total_[vertex]; };
    const auto add_edges = [&](u32 vertex) {
      mark(vertex);
      for (const u32 edge : edges_[vertex]) {
        if (is_in[edge]) continue;
        is_in[edge] = true;
        for (const u32 pin : pins_[edge]) {
          if (home_[pin] != kNone) continue;
          inside[pin] += static_cast<i64>(weight_[edge]);
          queue.push({gain(pin), pin, node});
        }
      }
    };
    for (u32 vertex = 0; vertex < size_.size(); ++vertex) {
      if (home_[vertex] == node) add_edges(vertex);
    }
    u64 placed = 0;
    u32 unmet = 0;
    while (placed < room) {
      u32 vertex = kNone;
      while (!queue.empty() && vertex == kNone) {
        const Move top = queue.top();
        queue.pop();
        if (home_[top.vertex] == kNone && top.gain == gain(top.vertex)) vertex = top.vertex;
      }
      if (vertex == kNone && start != kNone && home_[start] == kNone) vertex = start;
      for (; vertex == kNone && unmet < size_.size(); ++unmet) {
        if (home_[unmet] == kNone) vertex = unmet;
      }
      if (vertex == kNone || placed + size_[vertex] > room) break;
      move(vertex, node);
      placed += size_[vertex];
      add_edges(vertex);
    }
    return placed;
  }

  // The vertex that is met last, breadth first.
  u32 farthest(u32 start) const {
    std::vector<bool> is_met(size_.size(), false);
    std::vector<u32> order{start};
    is_met[start] = true;
    for (std::size_t at = 0; at < order.size(); ++at) {
      for (const u32 edge : edges_[order[at]]) {
        for (const u32 pin : pins_[edge]) {
          if (is_met[pin]) continue;
          is_met[pin] = true;
          order.push_back(pin);
        }
      }
    }
    return order.back();
  }

  // The weight of each edge for each node beyond the first.
  u64 cost() {
    u64 sum = 0;
    for (u32 edge = 0; edge < weight_.size(); ++edge) {
      met_.clear();
      for (const u32 pin : pins_[edge]) {
        if (std::find(met_.begin(), met_.end(), home_[pin]) == met_.end()) met_.push_back(home_[pin]);
      }
      sum += weight_[edge] * (met_.size() - 1);
    }
    return sum;
  }

  u32 best_home(u32 vertex) {
    find_scores(vertex);
    u32 best = kNone;
    for (u32 node = 0; node < nodes_; ++node) {
      if (load_[node] + size_[vertex] > most_) continue;
      if (best == kNone || score_[node] > score_[best] || (score_[node] == score_[best] && load_[node] < load_[best]))
        best = node;
    }
    return best != kNone ? best : static_cast<u32>(std::min_element(load_.begin(), load_.end()) - load_.begin());
  }

  // By node: the weight of the vertex's edges that have another vertex there.
  void find_scores(u32 vertex) {
    std::fill(score_.begin(), score_.end(), 0);
    for (const u32 edge : edges_[vertex]) {
      met_.clear();
      for (const u32 pin : pins_[edge]) {
        if (pin == vertex || home_[pin] == kNone || std::find(met_.begin(), met_.end(), home_[pin]) != met_.end())
          continue;
        met_.push_back(home_[pin]);
        score_[home_[pin]] += static_cast<i64>(weight_[edge]);
      }
    }
  }

  // The move that gains most; to kNone: there is no room anywhere, or its node would have too little.
  Move best_move(u32 vertex) {
    Move best{0, vertex, kNone};
    if (load_[home_[vertex]] < least_ + size_[vertex]) return best;
    find_scores(vertex);
    for (u32 node = 0; node < nodes_; ++node) {
      if (node == home_[vertex] || load_[node] + size_[vertex] > most_) continue;
      const i64 gain = score_[node] - score_[home_[vertex]];
      if (best.to == kNone || gain > best.gain) best = {gain, vertex, node};
    }
    return best;
  }

  void move(u32 vertex, u32 to) {
    BIP_ASSERT(to < nodes_, "vertex {} moves to {}", vertex, to);
    if (home_[vertex] != kNone) load_[home_[vertex]] -= size_[vertex];
    home_[vertex] = to;
    load_[to] += size_[vertex];
  }

  // Moves vertices to nodes that have less than least_, that which costs least first. No node falls below least_ by it,
  // nor below what the other has then: an empty node also gets a vertex if vertices are large.
  void fill_nodes() {
    for (u32 filled = 0; filled < nodes_; ++filled) {
      const u32 node = static_cast<u32>(std::min_element(load_.begin(), load_.end()) - load_.begin());
      if (load_[node] >= least_ || !fill_node(node)) return;
    }
  }

  // False: nothing could move.
  bool fill_node(u32 node) {
    const auto may_move = [&](u32 vertex) {
      if (is_fixed_[vertex] || home_[vertex] == node) return false;
      return load_[home_[vertex]] >= size_[vertex] + std::min(least_, load_[node] + size_[vertex]);
    };
    const auto gain = [&](u32 vertex) {
      find_scores(vertex);
      return score_[node] - score_[home_[vertex]];
    };
    std::priority_queue<Move> queue;
    for (u32 vertex = 0; vertex < size_.size(); ++vertex) {
      if (may_move(vertex)) queue.push({gain(vertex), vertex, node});
    }
    bool has_moved = false;
    while (load_[node] < least_ && !queue.empty()) {
      const u32 vertex = queue.top().vertex;
      const i64 queued = queue.top().gain;
      queue.pop();
      if (!may_move(vertex)) continue;
      // Others have moved since it was queued.
      if (const i64 now = gain(vertex); now != queued) {
        queue.push({now, vertex, node});
        continue;
      }
      move(vertex, node);
      has_moved = true;
      for (const u32 edge : edges_[vertex]) {
        for (const u32 pin : pins_[edge]) {
          if (may_move(pin)) queue.push({gain(pin), pin, node});
        }
      }
    }
    return has_moved;
  }

  // One pass. False: it gained nothing.
  bool improve() {
    std::priority_queue<Move> queue;
    std::vector<bool> is_done = is_fixed_;
    for (u32 vertex = 0; vertex < size_.size(); ++vertex) {
      if (is_done[vertex]) continue;
      if (const Move first = best_move(vertex); first.to != kNone) queue.push(first);
    }
    std::vector<std::pair<u32, u32>> undo;  // vertex, where it was
    i64 gained = 0, best = 0;
    std::size_t kept = 0;
    while (!queue.empty() && undo.size() - kept < kMostVain) {
      const Move top = queue.top();
      queue.pop();
      if (is_done[top.vertex]) continue;
      const Move now = best_move(top.vertex);
      if (now.to == kNone) continue;
      // Others have moved since it was queued.
      if (now.gain != top.gain || now.to != top.to) {
        queue.push(now);
        continue;
      }
      undo.emplace_back(now.vertex, home_[now.vertex]);
      is_done[now.vertex] = true;
      move(now.vertex, now.to);
      gained += now.gain;
      if (gained > best) {
        best = gained;
        kept = undo.size();
      }
      for (const u32 edge : edges_[now.vertex]) {
        for (const u32 pin : pins_[edge]) {
          if (is_done[pin]) continue;
          if (const Move next = best_move(pin); next.to != kNone) queue.push(next);
        }
      }
    }
    while (undo.size() > kept) {
      move(undo.back().first, undo.back().second);
      undo.pop_back();
    }
    return best > 0;
  }

  Placement& placement_;
  u32 nodes_;
  std::vector<u32> vertex_of_;  // by atom
  std::vector<u32> size_;       // by vertex: atoms
  std::vector<u32> home_;
  std::vector<bool> is_fixed_;
  std::vector<u64> weight_;   // by edge
  std::vector<i64> total_;    // by vertex: the weight of its edges
  Csr pins_, edges_;          // vertices by edge; edges by vertex
  std::vector<u64> load_;     // by node: atoms
  u64 most_ = 0, least_ = 0;  // atoms of a node
  // Scratch.
  std::vector<i64> score_;  // by node
  std::vector<u32> met_;
};

}  // namespace

void place_free_atoms(const Tables& tables, const PriorityTables& rules, const std::vector<u64>& counts,
                      Placement& placement) {
  BIP_ASSERT(!placement.nodes.empty() && placement.home.size() == tables.image->atoms.size, "{} homes on {} nodes",
             placement.home.size(), placement.nodes.size());
  BIP_ASSERT(counts.empty() || counts.size() == tables.interactions.size(), "{} counts", counts.size());
  AtomPlacer(tables, counts, atoms_together(tables, rules), placement).place();
}

}  // namespace bip::rt
