// See child_order.hpp. The cost of an order is the sum of the nets' spans.
#include "compiler/graph/child_order.hpp"

#include <algorithm>
#include <map>
#include <numeric>

#include "runtime/include/bip/assert.hpp"

namespace bip::graph {
namespace {

using u32 = std::uint32_t;

constexpr u32 kRounds = 30;
constexpr std::size_t kMostMoved = 40;  // children; moving each to each place costs their cube

class LinearOrder {
 public:
  LinearOrder(const std::vector<u32>& children, const std::vector<std::vector<u32>>& members)
      : count_(children.size()) {
    std::map<u32, u32> index;
    for (u32 k = 0; k < children.size(); ++k) index[children[k]] = k;
    for (const std::vector<u32>& list : members) {
      if (list.size() < 2) continue;
      std::vector<u32> net;
      for (const u32 child : list) net.push_back(index.at(child));
      nets_.push_back(std::move(net));
    }
    best_.resize(count_);
    std::iota(best_.begin(), best_.end(), 0u);
    lowest_ = cost(best_);
  }

  std::vector<u32> run() {
    std::vector<u32> order = best_;
    for (u32 round = 0; round < kRounds; ++round) {
      order = pulled(order);
      keep(order);
    }
    if (count_ <= kMostMoved) move_each();
    BIP_ASSERT(cost(best_) == lowest_, "the best order costs {}, not {}", cost(best_), lowest_);
    return best_;
  }

 private:
  [[nodiscard]] static std::vector<u32> places_of(const std::vector<u32>& order) {
    std::vector<u32> place(order.size());
    for (u32 k = 0; k < order.size(); ++k) place[order[k]] = k;
    return place;
  }
  [[nodiscard]] std::uint64_t cost(const std::vector<u32>& order) const {
    const std::vector<u32> place = places_of(order);
    std::uint64_t sum = 0;
    for (const std::vector<u32>& net : nets_) {
      u32 low = place[net.front()], high = low;
      for (const u32 child : net) {
        low = std::min(low, place[child]);
        high = std::max(high, place[child]);
      }
      sum += high - low;
    }
    return sum;
  }
  bool keep(const std::vector<u32>& order) {
    const std::uint64_t now = cost(order);
    if (now >= lowest_) return false;
    lowest_ = now;
    best_ = order;
    return true;
  }
  /// Sorted by the average of the middles of each child's nets.
  [[nodiscard]] std::vector<u32> pulled(const std::vector<u32>& order) const {
    const std::vector<u32> place = places_of(order);
    std::vector<double> sum(count_, 0), weight(count_, 0);
    for (const std::vector<u32>& net : nets_) {
      double middle = 0;
      for (const u32 child : net) middle += place[child];
      const double size = static_cast<double>(net.size());
      for (const u32 child : net) {
        sum[child] += middle / size / (size - 1);
        weight[child] += 1 / (size - 1);
      }
    }
    std::vector<u32> next = order;
    const auto wish = [&](u32 child) { return weight[child] == 0 ? place[child] : sum[child] / weight[child]; };
    std::stable_sort(next.begin(), next.end(), [&](u32 a, u32 b) { return wish(a) < wish(b); });
    return next;
  }
  void move_each() {
    for (bool is_better = true; is_better;) {
      is_better = false;
      for (u32 from = 0; from < count_; ++from)
        for (u32 to = 0; to < count_; ++to) {
          if (from == to) continue;
          std::vector<u32> order = best_;
          const u32 child = order[from];
          order.erase(order.begin() + from);
          order.insert(order.begin() + to, child);
          is_better = keep(order) || is_better;
        }
    }
  }

  std::size_t count_;
  std::vector<std::vector<u32>> nets_;
  std::vector<u32> best_;
  std::uint64_t lowest_ = 0;
};

}  // namespace

std::vector<u32> order_of_children(const std::vector<u32>& children, const std::vector<std::vector<u32>>& members) {
  std::vector<u32> order = LinearOrder(children, members).run();
  for (u32& child : order) child = children[child];
  return order;
}

std::vector<u32> sides_of_children(const std::vector<u32>& order, const std::vector<std::vector<u32>>& members) {
  constexpr u32 kNone = 2;
  std::map<u32, std::vector<u32>> beside;
  for (const std::vector<u32>& net : members) {
    if (net.size() != 2) continue;
    beside[net[0]].push_back(net[1]);
    beside[net[1]].push_back(net[0]);
  }
  std::map<u32, u32> side;
  for (const u32 child : order) side[child] = kNone;
  if (order.empty()) return {};
  std::vector<u32> open{order.front()};
  side[order.front()] = 0;
  for (std::size_t k = 0; k < open.size(); ++k)
    for (const u32 other : beside[open[k]]) {
      if (side[other] == side[open[k]]) return {};
      if (side[other] != kNone) continue;
      side[other] = 1 - side[open[k]];
      open.push_back(other);
    }
  if (open.size() != order.size()) return {};
  for (const std::vector<u32>& net : members) {
    const auto has = [&](u32 wanted) {
      return std::any_of(net.begin(), net.end(), [&](u32 child) { return side[child] == wanted; });
    };
    if (net.size() > 2 && !(has(0) && has(1))) return {};
  }
  std::vector<u32> sides;
  for (const u32 child : order) sides.push_back(side[child]);
  return sides;
}

}  // namespace bip::graph
