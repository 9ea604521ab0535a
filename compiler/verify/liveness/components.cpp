// See components.hpp.
#include "compiler/verify/liveness/components.hpp"

#include <utility>

#include "compiler/analysis/graph_algorithms.hpp"
#include "compiler/verify/liveness/fair_units.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr std::uint64_t kEdgesPerPoll = 1u << 16;

class ComponentSearch {
 public:
  ComponentSearch(const Product& product, const Fairness& fairness, const CancellationToken& cancellation)
      : product_(product),
        is_any_fair_(fairness.is_none()),
        cancellation_(cancellation),
        units_(product.graph().labels(), fairness) {
    found_.region.assign(static_cast<std::size_t>(product.size()), kUnvisited);
    if (is_any_fair_) return;
    possible_.assign(units_.size(), 0);
    last_possible_.assign(units_.size(), kUnvisited);
    is_taken_.assign(units_.size(), 0);
  }

  AcceptingComponent run() {
    StrongComponents<Product::Cursor> search;
    search.begin(found_.region.size());
    search.visit(0, *this);
    found_.visited = visited_;
    // Parts of components that were not fair as they are.
    while (!is_over_ && !parts_.empty()) {
      const std::vector<Product::Node> part = std::move(parts_.back());
      parts_.pop_back();
      within_ = found_.region[part.front()];
      search.begin(found_.region.size());
      for (const Product::Node node : part) {
        // Those that are complete have a region of their own.
        if (found_.region[node] == within_) search.visit(node, *this);
      }
    }
    return std::move(found_);
  }

  // The visitor of StrongComponents.
  Product::Cursor enter(Product::Node node) {
    ++visited_;
    return product_.first_edge(node);
  }
  Product::Node next(Product::Node node, Product::Cursor& cursor) {
    Product::Edge edge;
    while (!is_over_ && product_.next_edge(node, cursor, edge)) {
      if (++edges_ % kEdgesPerPoll == 0 && cancellation_.is_over()) {
        found_.end = AcceptingComponent::End::Stopped;
        is_over_ = true;
        break;
      }
      if (found_.region[edge.to] == within_) return edge.to;
    }
    return kNoSuccessor;
  }
  static void reach(Product::Node, Product::Node) {}
  void close(const Product::Node* nodes, std::size_t count) {
    if (is_over_) return;
    BIP_ASSERT(count != 0, "a component of no nodes");
    const Product::Node own = ++regions_;
    for (std::size_t k = 0; k < count; ++k) {
      BIP_ASSERT(found_.region[nodes[k]] == within_, "node {} is in two components", nodes[k]);
      found_.region[nodes[k]] = own;
    }
    // All automaton states of a component are in one component of the automaton.
    if (!product_.may_accept(nodes[0]) || !is_accepting(nodes, count)) return;
    found_.end = AcceptingComponent::End::Found;
    found_.component = own;
    is_over_ = true;
  }

 private:
  static constexpr Product::Node kUnvisited = 0;

  // Has the component a cycle with all marks, and is it fair? If only strong fairness is missing, its part that may be
  // fair is noted for later.
  bool is_accepting(const Product::Node* nodes, std::size_t count) {
    const Product::Node own = found_.region[nodes[0]];
    std::uint32_t marks = 0;
    bool has_cycle = false;
    for (std::size_t k = 0; k < count; ++k) {
      Product::Cursor cursor = product_.first_edge(nodes[k]);
      Product::Edge edge;
      while (product_.next_edge(nodes[k], cursor, edge)) {
        if (found_.region[edge.to] != own) continue;
        has_cycle = true;
        marks |= edge.marks;
        if (is_any_fair_ && marks == product_.all_marks()) return true;
      }
    }
    if (!has_cycle || marks != product_.all_marks()) return false;
    if (is_any_fair_) return true;
    count_units(nodes, count);
    bool lacks_strong = false;
    for (std::uint32_t unit = 0; unit < units_.size(); ++unit) {
      BIP_ASSERT(is_taken_[unit] == 0 || possible_[unit] != 0, "unit {} is taken and nowhere possible", unit);
      if (is_taken_[unit] != 0) continue;
      if (units_.is_strong(unit)) lacks_strong = lacks_strong || possible_[unit] != 0;
      else if (possible_[unit] == count) return false;
    }
    if (lacks_strong) divide(nodes, count);
    return !lacks_strong;
  }

  // By unit: in how many of the nodes is it possible, and does the component take it?
  void count_units(const Product::Node* nodes, std::size_t count) {
    const Product::Node own = found_.region[nodes[0]];
    std::fill(possible_.begin(), possible_.end(), 0);
    std::fill(is_taken_.begin(), is_taken_.end(), std::uint8_t{0});
    std::fill(last_possible_.begin(), last_possible_.end(), kNoSuccessor);
    const rt::StateGraph& graph = product_.graph();
    for (std::size_t k = 0; k < count; ++k) {
      const Product::Node node = nodes[k];
      const std::uint32_t state = product_.state_of(node);
      for (std::uint64_t step = graph.first_step(state); step < graph.end_of_steps(state); ++step) {
        for (const std::uint32_t unit : units_.of(graph.label(step))) {
          if (last_possible_[unit] == node) continue;
          last_possible_[unit] = node;
          ++possible_[unit];
        }
      }
      Product::Cursor cursor = product_.first_edge(node);
      Product::Edge edge;
      while (product_.next_edge(node, cursor, edge)) {
        if (found_.region[edge.to] != own || edge.label == rt::kNone) continue;
        for (const std::uint32_t unit : units_.of(edge.label)) is_taken_[unit] = 1;
      }
    }
  }

  // The nodes in which nothing is possible of which strong fairness is asked and that the component does not take.
  void divide(const Product::Node* nodes, std::size_t count) {
    const rt::StateGraph& graph = product_.graph();
    const Product::Node rest = ++regions_;
    std::vector<Product::Node> part;
    for (std::size_t k = 0; k < count; ++k) {
      const std::uint32_t state = product_.state_of(nodes[k]);
      bool is_kept = true;
      for (std::uint64_t step = graph.first_step(state); step < graph.end_of_steps(state) && is_kept; ++step) {
        for (const std::uint32_t unit : units_.of(graph.label(step)))
          is_kept = is_kept && (is_taken_[unit] != 0 || !units_.is_strong(unit));
      }
      if (!is_kept) continue;
      found_.region[nodes[k]] = rest;
      part.push_back(nodes[k]);
    }
    BIP_ASSERT(part.size() < count, "a component of {} nodes remains as it is", count);
    if (!part.empty()) parts_.push_back(std::move(part));
  }

  const Product& product_;
  const bool is_any_fair_;
  const CancellationToken& cancellation_;
  const FairUnits units_;
  AcceptingComponent found_;
  Product::Node regions_ = kUnvisited, within_ = kUnvisited;  // the region that is decomposed
  std::vector<std::vector<Product::Node>> parts_;
  std::uint64_t visited_ = 0, edges_ = 0;
  bool is_over_ = false;
  // By unit, of the component at hand.
  std::vector<std::uint64_t> possible_;
  std::vector<Product::Node> last_possible_;
  std::vector<std::uint8_t> is_taken_;
};

}  // namespace

AcceptingComponent find_accepting_component(const Product& product, const Fairness& fairness,
                                            const CancellationToken& cancellation) {
  return ComponentSearch(product, fairness, cancellation).run();
}

}  // namespace bip::verify
