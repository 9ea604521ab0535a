// See layers.hpp.
#include "compiler/graph/layers.hpp"

#include <algorithm>
#include <numeric>

#include "compiler/analysis/graph_algorithms.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::graph {
namespace {

constexpr std::uint32_t kSweeps = 16, kAlignments = 24;
constexpr double kBeside = 18, kBetween = 26;
constexpr double kRounding = 1e-3;  // of sums of coordinates

class LayeredLayout {
 public:
  LayeredLayout(std::vector<LayerNode>& nodes, std::vector<LayerEdge>& edges) : nodes_(nodes), edges_(edges) {}

  LayerSize run() {
    turn_edges();
    find_layers();
    split_edges();
    order_layers();
    align();
    return finish();
  }

 private:
  using Row = std::uint32_t;
  /// A node, or the part of a long edge in a layer.
  struct Item {
    Row layer = 0;
    double left = 4, right = 4, height = 0;
    double x = 0, y = 0, place = 0;
    std::vector<Row> up, down;
    bool is_edge = false;
  };

  void turn_edges() {
    std::vector<std::pair<Row, Row>> ends;
    for (const LayerEdge& edge : edges_) {
      BIP_ASSERT(edge.from != edge.to, "a loop at node {}", edge.from);
      ends.emplace_back(edge.from, edge.to);
    }
    is_turned_ = edges_leading_back(nodes_.size(), ends);
  }
  [[nodiscard]] Row upper(Row e) const { return is_turned_[e] ? edges_[e].to : edges_[e].from; }
  [[nodiscard]] Row lower(Row e) const { return is_turned_[e] ? edges_[e].from : edges_[e].to; }

  /// The longest path to each node; then nodes with more edges down than up move down, towards their successors.
  void find_layers() {
    std::vector<std::vector<Row>> down(nodes_.size()), up(nodes_.size());
    std::vector<Row> missing(nodes_.size(), 0), order;
    for (Row e = 0; e < edges_.size(); ++e) {
      down[upper(e)].push_back(lower(e));
      up[lower(e)].push_back(upper(e));
      ++missing[lower(e)];
    }
    const bool is_ordered = topological_order(missing, order, [&](Row node, auto&& see) {
      for (const Row to : down[node]) see(to);
    });
    (void)is_ordered;
    BIP_ASSERT(is_ordered, "{} of {} nodes are in an order", order.size(), nodes_.size());
    items_.resize(nodes_.size());
    for (const Row node : order)
      for (const Row to : down[node]) items_[to].layer = std::max(items_[to].layer, items_[node].layer + 1);
    for (std::size_t k = order.size(); k-- > 0;) {
      const Row node = order[k];
      if (down[node].empty() || down[node].size() <= up[node].size()) continue;
      Row nearest = items_[down[node].front()].layer;
      for (const Row to : down[node]) nearest = std::min(nearest, items_[to].layer);
      items_[node].layer = nearest - 1;
    }
    for (Row n = 0; n < nodes_.size(); ++n) {
      items_[n].left = nodes_[n].left;
      items_[n].right = nodes_[n].right;
      items_[n].height = nodes_[n].height;
    }
  }

  void split_edges() {
    for (Row e = 0; e < edges_.size(); ++e) {
      BIP_ASSERT(items_[upper(e)].layer < items_[lower(e)].layer, "edge {} leads from layer {} to {}", e,
                 items_[upper(e)].layer, items_[lower(e)].layer);
      std::vector<Row> chain{upper(e)};
      for (Row layer = items_[upper(e)].layer + 1; layer < items_[lower(e)].layer; ++layer) {
        chain.push_back(static_cast<Row>(items_.size()));
        items_.push_back({.layer = layer, .up = {}, .down = {}, .is_edge = true});
      }
      chain.push_back(lower(e));
      for (std::size_t k = 1; k < chain.size(); ++k) {
        items_[chain[k - 1]].down.push_back(chain[k]);
        items_[chain[k]].up.push_back(chain[k - 1]);
      }
      chains_.push_back(std::move(chain));
    }
    for (Row k = 0; k < items_.size(); ++k) {
      if (items_[k].layer >= layers_.size()) layers_.resize(items_[k].layer + 1);
      layers_[items_[k].layer].push_back(k);
    }
  }

  // -- Order --

  void number_places() {
    for (const std::vector<Row>& layer : layers_)
      for (std::size_t k = 0; k < layer.size(); ++k) items_[layer[k]].place = static_cast<double>(k);
  }
  [[nodiscard]] std::uint64_t crossings_below(std::size_t at) const {
    std::vector<std::pair<double, double>> lines;
    for (const Row item : layers_[at])
      for (const Row to : items_[item].down) lines.push_back({items_[item].place, items_[to].place});
    std::sort(lines.begin(), lines.end());
    // Inversions, by insertion into the sorted list of lower ends.
    std::vector<double> seen;
    std::uint64_t count = 0;
    for (const auto& [from, to] : lines) {
      const auto where = std::upper_bound(seen.begin(), seen.end(), to);
      count += static_cast<std::uint64_t>(seen.end() - where);
      seen.insert(where, to);
    }
    return count;
  }
  [[nodiscard]] std::uint64_t crossings() const {
    std::uint64_t sum = 0;
    for (std::size_t k = 0; k + 1 < layers_.size(); ++k) sum += crossings_below(k);
    return sum;
  }
  void order_layers() {
    number_places();
    std::vector<std::vector<Row>> best = layers_;
    std::uint64_t fewest = crossings();
    for (std::uint32_t sweep = 0; sweep < kSweeps && fewest > 0; ++sweep) {
      const bool is_down = sweep % 2 == 0;
      for (std::size_t k = 0; k < layers_.size(); ++k) sort_layer(is_down ? k : layers_.size() - 1 - k, is_down);
      number_places();
      if (const std::uint64_t now = crossings(); now < fewest) {
        fewest = now;
        best = layers_;
      }
    }
    layers_ = best;
    number_places();
    BIP_ASSERT(crossings() == fewest, "the best order has {} crossings, {} were counted", crossings(), fewest);
  }
  void sort_layer(std::size_t at, bool is_down) {
    std::vector<Row>& layer = layers_[at];
    const auto wish = [&](Row item) {
      const std::vector<Row>& others = is_down ? items_[item].up : items_[item].down;
      if (others.empty()) return items_[item].place;
      double sum = 0;
      for (const Row other : others) sum += items_[other].place;
      return sum / static_cast<double>(others.size());
    };
    std::vector<std::pair<double, Row>> wishes;
    for (const Row item : layer) wishes.push_back({wish(item), item});
    std::stable_sort(wishes.begin(), wishes.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t k = 0; k < layer.size(); ++k) {
      layer[k] = wishes[k].second;
      items_[layer[k]].place = static_cast<double>(k);
    }
  }

  // -- Coordinates --

  void align() {
    for (const std::vector<Row>& layer : layers_) {
      double x = 0;
      for (const Row item : layer) {
        items_[item].x = x + items_[item].left;
        x += items_[item].left + items_[item].right + kBeside;
      }
    }
    for (std::uint32_t round = 0; round < kAlignments; ++round)
      for (std::size_t k = 0; k < layers_.size(); ++k)
        align_layer(round % 2 == 0 ? k : layers_.size() - 1 - k, round % 2 == 0 ? 1 : 2);
  }
  /// Moves a layer's items to the average of their neighbours, as near as their order and sizes allow: the least
  /// squares under x[i+1] - x[i] >= gap, by merging blocks (pool adjacent violators).
  void align_layer(std::size_t at, int side) {
    struct Block {
      double sum = 0, weight = 0;
      std::size_t first = 0;
    };
    const std::vector<Row>& layer = layers_[at];
    std::vector<double> offset(layer.size(), 0);
    std::vector<Block> blocks;
    for (std::size_t k = 0; k < layer.size(); ++k) {
      const Item& item = items_[layer[k]];
      if (k > 0) offset[k] = offset[k - 1] + items_[layer[k - 1]].right + item.left + kBeside;
      double sum = 0, weight = 0;
      const auto pull = [&](const std::vector<Row>& others, double part) {
        for (const Row other : others) {
          // Long edges are straight before all else.
          const double force = part * (item.is_edge && items_[other].is_edge ? 8 : 1);
          sum += force * items_[other].x;
          weight += force;
        }
      };
      pull(item.up, side == 1 ? 1 : 0.3);
      pull(item.down, side == 2 ? 1 : 0.3);
      if (weight == 0) {
        sum = item.x * 0.01;
        weight = 0.01;
      }
      blocks.push_back({sum - offset[k] * weight, weight, k});
      while (blocks.size() > 1 && blocks[blocks.size() - 2].sum / blocks[blocks.size() - 2].weight >
                                      blocks.back().sum / blocks.back().weight) {
        const Block last = blocks.back();
        blocks.pop_back();
        blocks.back().sum += last.sum;
        blocks.back().weight += last.weight;
      }
    }
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      const std::size_t end = b + 1 < blocks.size() ? blocks[b + 1].first : layer.size();
      for (std::size_t k = blocks[b].first; k < end; ++k)
        items_[layer[k]].x = blocks[b].sum / blocks[b].weight + offset[k];
    }
    for (std::size_t k = 1; k < layer.size(); ++k)
      BIP_ASSERT(items_[layer[k]].x - items_[layer[k - 1]].x > offset[k] - offset[k - 1] - kRounding,
                 "items {} and {} of a layer overlap", k - 1, k);
  }

  LayerSize finish() {
    double left = 1e18, right = -1e18, y = 0;
    std::vector<double> heights;
    for (const std::vector<Row>& layer : layers_) {
      double height = 0;
      for (const Row item : layer) {
        height = std::max(height, items_[item].height);
        left = std::min(left, items_[item].x - items_[item].left);
        right = std::max(right, items_[item].x + items_[item].right);
      }
      for (const Row item : layer) items_[item].y = y;
      heights.push_back(height);
      y += height + kBetween;
    }
    for (Item& item : items_) item.x -= left;
    for (Row n = 0; n < nodes_.size(); ++n) {
      BIP_ASSERT(items_[n].x - items_[n].left > -kRounding && items_[n].x + items_[n].right < right - left + kRounding,
                 "node {} is at {} of {}", n, items_[n].x, right - left);
      nodes_[n].x = items_[n].x;
      nodes_[n].y = items_[n].y + (heights[items_[n].layer] - items_[n].height) / 2;
    }
    for (Row e = 0; e < edges_.size(); ++e) {
      std::vector<Point>& points = edges_[e].points;
      const std::vector<Row>& chain = chains_[e];
      for (std::size_t k = 0; k < chain.size(); ++k) {
        const Item& item = items_[chain[k]];
        const double height = heights[item.layer];
        const bool is_node = !item.is_edge;
        const double middle = item.y + height / 2, half = is_node ? item.height / 2 : 0;
        // A node's lines end at its edge; an edge passes its layer straight.
        if (k > 0) {
          points.push_back({item.x, item.y});
          points.push_back({item.x, is_node ? middle - half : item.y + height});
        }
        if (k == 0) {
          points.push_back({item.x, middle + half});
          points.push_back({item.x, item.y + height});
        }
      }
      if (is_turned_[e]) std::reverse(points.begin(), points.end());
    }
    return {layers_.empty() ? 0 : right - left, layers_.empty() ? 0 : y - kBetween};
  }

  std::vector<LayerNode>& nodes_;
  std::vector<LayerEdge>& edges_;
  std::vector<bool> is_turned_;
  std::vector<Item> items_;  // nodes first
  std::vector<std::vector<Row>> chains_, layers_;
};

}  // namespace

std::vector<bool> edges_leading_back(std::size_t nodes,
                                     const std::vector<std::pair<std::uint32_t, std::uint32_t>>& edges,
                                     std::vector<std::uint32_t> roots) {
  std::vector<std::vector<std::uint32_t>> out(nodes);
  for (std::uint32_t e = 0; e < edges.size(); ++e) out[edges[e].first].push_back(e);
  for (std::uint32_t node = 0; node < nodes; ++node) roots.push_back(node);
  enum class Visit : std::uint8_t { No, Open, Done };
  std::vector<Visit> visits(nodes, Visit::No);
  std::vector<bool> leads_back(edges.size(), false);
  for (const std::uint32_t root : roots) {
    if (visits[root] != Visit::No) continue;
    std::vector<std::pair<std::uint32_t, std::size_t>> open{{root, 0}};
    visits[root] = Visit::Open;
    while (!open.empty()) {
      auto& [node, next] = open.back();
      if (next == out[node].size()) {
        visits[node] = Visit::Done;
        open.pop_back();
        continue;
      }
      const std::uint32_t edge = out[node][next++], to = edges[edge].second;
      leads_back[edge] = visits[to] == Visit::Open;
      if (visits[to] != Visit::No) continue;
      visits[to] = Visit::Open;
      open.push_back({to, 0});
    }
  }
  return leads_back;
}

LayerSize lay_out_layers(std::vector<LayerNode>& nodes, std::vector<LayerEdge>& edges) {
  BIP_ASSERT(std::all_of(nodes.begin(), nodes.end(),
                         [](const LayerNode& node) { return node.left >= 0 && node.right >= 0 && node.height >= 0; }),
             "a node reaches no way, of {}", nodes.size());
  return LayeredLayout(nodes, edges).run();
}

}  // namespace bip::graph
