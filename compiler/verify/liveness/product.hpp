// The product of a state graph and an automaton, as an enumeration of its edges.
//
// A node is a state of the graph and a state of the automaton, numbered densely: state * width + automaton state;
// nothing is built. After the last state of a run its position repeats: an edge without a label to the same state.
// States that the graph has not expanded yet have no edges.
#pragma once
#include <cstdint>
#include <vector>

#include "compiler/verify/liveness/automaton.hpp"
#include "runtime/explore/state_graph.hpp"

namespace bip::verify {

/// Which of the formula's conditions on steps hold of a step with the label: bit k is condition k.
[[nodiscard]] std::uint64_t happens(const Formula& formula, const rt::StepLabels& labels, std::uint32_t label);

class Product {
 public:
  using Node = std::uint32_t;
  struct Cursor {
    std::uint64_t step = 0;
    std::uint32_t match = 0;  // row of matches_
  };
  struct Edge {
    Node to = 0;
    std::uint32_t label = rt::kNone;  // kNone: the run has ended
    std::uint32_t marks = 0;
  };

  /// The automaton must not be empty. Both must outlive the product and stay as they are. Cost: valuations of the graph
  /// times edges of the automaton.
  Product(const rt::StateGraph& graph, const Automaton& automaton, const Formula& formula);

  /// Nodes, those that no run reaches among them; below 2^32 if fits() says so.
  [[nodiscard]] std::uint64_t size() const { return std::uint64_t{graph_.states()} * width_; }
  [[nodiscard]] static bool fits(std::uint64_t states, const Automaton& automaton) {
    return states * automaton.edges.size() < kNoSuccessor;
  }
  [[nodiscard]] const rt::StateGraph& graph() const { return graph_; }
  [[nodiscard]] std::uint32_t all_marks() const { return automaton_.marks; }
  [[nodiscard]] std::uint32_t state_of(Node node) const { return node / width_; }
  /// Is the automaton's state on a cycle with all marks?
  [[nodiscard]] bool may_accept(Node node) const { return automaton_.may_accept[node % width_] != 0; }

  /// Does the node accept whatever follows? Then runs that come here violate the formula, and so does what led here.
  [[nodiscard]] bool is_decided(Node node) const { return is_decided_[node % width_] != 0; }
  /// Has the node, of an expanded state, an edge to a decided one that its state alone allows, whatever the step? Where
  /// all steps end in errors nothing happens.
  [[nodiscard]] bool is_decided_by_state(Node node) const {
    const std::uint32_t state = state_of(node);
    if (state >= graph_.expanded()) return false;
    const Slice own = slice(node);
    const bool has_steps = graph_.first_step(state) != graph_.end_of_steps(state);
    for (std::uint32_t row = own.first; row < own.end; ++row) {
      const AutomatonEdge& match = matches_[row];
      if (match.required == 0 && (match.forbidden == 0 || !has_steps) && is_decided_[match.to] != 0) return true;
    }
    return false;
  }

  [[nodiscard]] Cursor first_edge(Node node) const {
    const std::uint32_t state = state_of(node);
    if (state >= graph_.expanded()) return {};
    return {graph_.first_step(state), slice(node).first};
  }
  /// The edge at the cursor, which moves on. False: no edge is left.
  bool next_edge(Node node, Cursor& cursor, Edge& edge) const {
    const std::uint32_t state = state_of(node);
    if (state >= graph_.expanded()) return false;
    const Slice own = slice(node);
    if (own.first == own.end) return false;
    const std::uint64_t steps = graph_.end_of_steps(state), end = steps + (graph_.is_end(state) ? 1 : 0);
    while (cursor.step < end) {
      if (cursor.match == own.end) {
        ++cursor.step;
        cursor.match = own.first;
        continue;
      }
      const AutomatonEdge& match = matches_[cursor.match++];
      const bool is_step = cursor.step < steps;
      edge.label = is_step ? graph_.label(cursor.step) : rt::kNone;
      const std::uint64_t happens = is_step ? happens_[edge.label] : 0;
      if ((match.required & ~happens) != 0 || (match.forbidden & happens) != 0) continue;
      edge.to = (is_step ? graph_.target(cursor.step) : state) * width_ + match.to;
      edge.marks = match.marks;
      return true;
    }
    return false;
  }

 private:
  struct Slice {
    std::uint32_t first = 0, end = 0;
  };
  static constexpr std::uint32_t kNoSuccessor = 0xffffffffu;
  [[nodiscard]] Slice slice(Node node) const {
    return slices_[std::size_t{graph_.value(state_of(node))} * width_ + node % width_];
  }

  const rt::StateGraph& graph_;
  const Automaton& automaton_;
  const std::uint32_t width_;
  std::vector<AutomatonEdge> matches_;    // with their conditions on steps alone
  std::vector<Slice> slices_;             // by valuation and automaton state: rows of matches_
  std::vector<std::uint8_t> is_decided_;  // by state of the automaton
  std::vector<std::uint64_t> happens_;    // by label: conditions on steps, in the automaton's bits
};

}  // namespace bip::verify
