// See lasso.hpp.
#include "compiler/verify/liveness/lasso.hpp"

#include <algorithm>

#include "compiler/verify/liveness/fair_units.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr Product::Node kNoNode = 0xffffffffu;

struct ProductStep {
  Product::Node from = kNoNode;
  Product::Edge edge;
};

class LassoSearch {
 public:
  LassoSearch(const Product& product, const AcceptingComponent& found, const Fairness& fairness)
      : product_(product),
        found_(found),
        is_any_fair_(fairness.is_none()),
        units_(product.graph().labels(), fairness),
        has_weak_(fairness.has(FairnessKind::Weak)),
        parent_(static_cast<std::size_t>(product.size()), kNoNode),
        missing_(units_.size(), 0),
        is_taken_(units_.size(), 0) {}

  Lasso run() {
    Lasso lasso;
    Product::Node entry = 0;
    if (!is_inside(0)) {
      const std::vector<ProductStep> stem =
          search(0, Within::Product, [&](const ProductStep& step) { return is_inside(step.edge.to); });
      entry = stem.back().edge.to;
      append(lasso.stem, stem);
    }
    std::vector<ProductStep> cycle;
    find_cycle(entry, cycle);
    BIP_ASSERT(cycle.front().from == entry && cycle.back().edge.to == entry, "the cycle does not close");
    BIP_ASSERT(is_connected(cycle), "the cycle has a gap");
    append(lasso.cycle, cycle);
    return lasso;
  }

 private:
  enum class Within : std::uint8_t { Product, Component };
  [[nodiscard]] bool is_inside(Product::Node node) const { return found_.region[node] == found_.component; }

  [[nodiscard]] static bool is_connected(const std::vector<ProductStep>& steps) {
    return std::adjacent_find(steps.begin(), steps.end(), [](const ProductStep& step, const ProductStep& next) {
             return step.edge.to != next.from;
           }) == steps.end();
  }

  // The fewest edges from a node to one that is wanted, that one included. There is such an edge.
  template <class IsWanted>
  std::vector<ProductStep> search(Product::Node from, Within within, const IsWanted& is_wanted) {
    std::vector<Product::Node> queue{from};
    parent_[from] = from;
    ProductStep last;
    for (std::size_t at = 0; at < queue.size() && last.from == kNoNode; ++at) {
      Product::Cursor cursor = product_.first_edge(queue[at]);
      Product::Edge edge;
      while (product_.next_edge(queue[at], cursor, edge)) {
        if (within == Within::Component && !is_inside(edge.to)) continue;
        if (is_wanted(ProductStep{queue[at], edge})) {
          last = {queue[at], edge};
          break;
        }
        if (parent_[edge.to] != kNoNode) continue;
        parent_[edge.to] = queue[at];
        queue.push_back(edge.to);
      }
    }
    BIP_ENSURE(last.from != kNoNode, "a component lacks the edge that made it one");
    std::vector<ProductStep> steps{last};
    for (Product::Node node = last.from; node != from; node = parent_[node]) {
      Product::Cursor cursor = product_.first_edge(parent_[node]);
      ProductStep step{parent_[node], {}};
      while (product_.next_edge(step.from, cursor, step.edge) && step.edge.to != node) {
      }
      steps.push_back(step);
    }
    std::reverse(steps.begin(), steps.end());
    BIP_ASSERT(steps.front().from == from && is_connected(steps), "the way from node {} has a gap", from);
    for (const Product::Node node : queue) parent_[node] = kNoNode;
    return steps;
  }

  void find_cycle(Product::Node entry, std::vector<ProductStep>& cycle) {
    marks_ = product_.all_marks();
    visit_first(entry);
    Product::Node at = entry;
    const auto go = [&](const std::vector<ProductStep>& steps) {
      for (const ProductStep& step : steps) take(step.edge);
      cycle.insert(cycle.end(), steps.begin(), steps.end());
      at = cycle.back().edge.to;
    };
    do {
      while (is_incomplete())
        go(search(at, Within::Component, [&](const ProductStep& step) { return brings_something(step.edge); }));
      if (at != entry || cycle.empty())
        go(search(at, Within::Component, [&](const ProductStep& step) { return step.edge.to == entry; }));
    } while (is_incomplete());
  }

  // Weak: units that were possible in all states so far and not taken; strong: those that were possible in some.
  [[nodiscard]] bool is_incomplete() const {
    return marks_ != 0 || std::find(missing_.begin(), missing_.end(), std::uint8_t{1}) != missing_.end();
  }
  void visit_first(Product::Node node) {
    if (is_any_fair_) return;
    for (const std::uint32_t unit : possible_in(node)) missing_[unit] = 1;
  }
  void take(const Product::Edge& edge) {
    marks_ &= ~edge.marks;
    if (is_any_fair_) return;
    if (edge.label != rt::kNone) {
      for (const std::uint32_t unit : units_.of(edge.label)) {
        is_taken_[unit] = 1;
        missing_[unit] = 0;
      }
    }
    const std::vector<std::uint32_t>& possible = possible_in(edge.to);
    for (const std::uint32_t unit : possible) {
      if (units_.is_strong(unit)) missing_[unit] = is_taken_[unit] != 0 ? 0 : 1;
    }
    for (std::uint32_t unit = 0; unit < missing_.size(); ++unit) {
      if (is_excused(unit, possible)) missing_[unit] = 0;
    }
  }
  [[nodiscard]] bool brings_something(const Product::Edge& edge) {
    if ((edge.marks & marks_) != 0) return true;
    if (is_any_fair_ || edge.label == rt::kNone) return false;
    for (const std::uint32_t unit : units_.of(edge.label)) {
      if (missing_[unit] != 0) return true;
    }
    if (!has_weak_) return false;
    const std::vector<std::uint32_t>& possible = possible_in(edge.to);
    for (std::uint32_t unit = 0; unit < missing_.size(); ++unit) {
      if (is_excused(unit, possible)) return true;
    }
    return false;
  }
  // It was missing and need not happen, because these are the units that are possible in some state.
  [[nodiscard]] bool is_excused(std::uint32_t unit, const std::vector<std::uint32_t>& possible) const {
    return missing_[unit] != 0 && !units_.is_strong(unit) &&
           !std::binary_search(possible.begin(), possible.end(), unit);
  }
  const std::vector<std::uint32_t>& possible_in(Product::Node node) {
    const rt::StateGraph& graph = product_.graph();
    const std::uint32_t state = product_.state_of(node);
    possible_.clear();
    for (std::uint64_t step = graph.first_step(state); step < graph.end_of_steps(state); ++step) {
      const std::vector<std::uint32_t>& units = units_.of(graph.label(step));
      possible_.insert(possible_.end(), units.begin(), units.end());
    }
    std::sort(possible_.begin(), possible_.end());
    possible_.erase(std::unique(possible_.begin(), possible_.end()), possible_.end());
    return possible_;
  }

  // Positions that repeat because the run has ended are no steps.
  void append(std::vector<LassoStep>& steps, const std::vector<ProductStep>& from) const {
    for (const ProductStep& step : from) {
      if (step.edge.label != rt::kNone) steps.push_back({step.edge.label, product_.state_of(step.edge.to)});
    }
  }

  const Product& product_;
  const AcceptingComponent& found_;
  const bool is_any_fair_;
  const FairUnits units_;
  const bool has_weak_;
  std::vector<Product::Node> parent_;             // of one search; kNoNode elsewhere
  std::uint32_t marks_ = 0;                       // that are missing
  std::vector<std::uint8_t> missing_, is_taken_;  // by unit
  std::vector<std::uint32_t> possible_;
};

}  // namespace

Lasso find_lasso(const Product& product, const AcceptingComponent& found, const Fairness& fairness) {
  BIP_ASSERT(found.end == AcceptingComponent::End::Found && found.region.size() == product.size(),
             "there is no component of this product to go to");
  return LassoSearch(product, found, fairness).run();
}

}  // namespace bip::verify
