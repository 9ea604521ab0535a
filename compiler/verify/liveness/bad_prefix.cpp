// See bad_prefix.hpp.
#include "compiler/verify/liveness/bad_prefix.hpp"

#include <algorithm>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr Product::Node kNoParent = 0xffffffffu;
constexpr std::uint64_t kNodesPerLook = 4096;

class PrefixSearch {
 public:
  explicit PrefixSearch(const Product& product)
      : product_(product), parent_(static_cast<std::size_t>(product.size()), kNoParent) {}

  BadPrefix run(const CancellationToken& cancellation) {
    BadPrefix found;
    std::vector<Product::Node> queue{0};
    parent_[0] = 0;
    for (std::size_t at = 0; at < queue.size(); ++at) {
      const Product::Node node = queue[at];
      found.visited = at + 1;
      if (found.visited % kNodesPerLook == 0 && cancellation.is_over()) {
        found.end = BadPrefix::End::Stopped;
        return found;
      }
      if (product_.is_decided(node) || product_.is_decided_by_state(node)) {
        found.end = BadPrefix::End::Found;
        add_steps(node, found);
        return found;
      }
      Product::Cursor cursor = product_.first_edge(node);
      Product::Edge edge;
      while (product_.next_edge(node, cursor, edge)) {
        if (product_.is_decided(edge.to)) {
          found.end = BadPrefix::End::Found;
          add_steps(node, found);
          found.ends_with_step = edge.label != rt::kNone;
          if (found.ends_with_step) found.steps.push_back({edge.label, product_.state_of(edge.to)});
          return found;
        }
        if (parent_[edge.to] != kNoParent) continue;
        parent_[edge.to] = node;
        queue.push_back(edge.to);
      }
    }
    return found;
  }

 private:
  void add_steps(Product::Node node, BadPrefix& found) const {
    BIP_ASSERT(node < parent_.size() && parent_[node] != kNoParent, "node {} was not reached", node);
    std::vector<LassoStep>& steps = found.steps;
    for (; node != 0; node = parent_[node]) {
      Product::Cursor cursor = product_.first_edge(parent_[node]);
      Product::Edge edge;
      while (product_.next_edge(parent_[node], cursor, edge) && edge.to != node) {
      }
      if (edge.label != rt::kNone) steps.push_back({edge.label, product_.state_of(node)});
      else ++found.repeats;
    }
    std::reverse(steps.begin(), steps.end());
  }

  const Product& product_;
  std::vector<Product::Node> parent_;  // the initial node is its own
};

}  // namespace

BadPrefix find_bad_prefix(const Product& product, const CancellationToken& cancellation) {
  return PrefixSearch(product).run(cancellation);
}

}  // namespace bip::verify
