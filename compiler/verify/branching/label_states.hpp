// Which states of a graph satisfy which nodes of a formula of branching time, by fixpoints from the operands to the
// operators (Clarke, Emerson, Sistla 1986, section 3), each linear in the steps of the graph.
//
// Of a graph that is not complete two bounds are known: the states that satisfy a node whatever the states without
// steps satisfy, and those that may. The formula is in negation normal form, so all nodes are monotone, and taking
// conditions of such states as false or as true everywhere gives the bounds. A state with steps is one that is
// expanded; if none of them leads anywhere, the state repeats. Memory: a bit for each node and state, the predecessors
// of all states (4 bytes a step, 8 a state) and a counter of 4 bytes for each state.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "compiler/verify/property/branching_formula.hpp"
#include "compiler/verify/solver/cancellation.hpp"
#include "runtime/explore/state_graph.hpp"

namespace bip::verify {

class StateSet {
 public:
  explicit StateSet(std::uint32_t states = 0) : words_((std::size_t{states} + 63) / 64, 0) {}
  [[nodiscard]] bool has(std::uint32_t state) const { return (words_[state / 64] >> (state % 64) & 1) != 0; }
  void add(std::uint32_t state) { words_[state / 64] |= std::uint64_t{1} << (state % 64); }
  /// Bits behind the last state have no meaning.
  void complement() {
    for (std::uint64_t& word : words_) word = ~word;
  }
  void intersect(const StateSet& other) {
    for (std::size_t k = 0; k < words_.size(); ++k) words_[k] &= other.words_[k];
  }
  void unite(const StateSet& other) {
    for (std::size_t k = 0; k < words_.size(); ++k) words_[k] |= other.words_[k];
  }

 private:
  std::vector<std::uint64_t> words_;
};

/// The steps of a graph backwards, each of them as often as there are steps.
class Predecessors {
 public:
  explicit Predecessors(const rt::StateGraph& graph);
  [[nodiscard]] const std::uint32_t* begin(std::uint32_t state) const { return sources_.data() + first_[state]; }
  [[nodiscard]] const std::uint32_t* end(std::uint32_t state) const { return sources_.data() + first_[state + 1]; }

 private:
  std::vector<std::uint64_t> first_;
  std::vector<std::uint32_t> sources_;
};

/// Surely: states that satisfy a node whatever is behind the graph; Possibly: those that may. They are the same if it
/// is complete.
enum class Bound : std::uint8_t { Surely, Possibly };

/// The states that satisfy each node, by node. The predicates of the graph are the formula's conditions. Nothing if the
/// token is over.
[[nodiscard]] std::optional<std::vector<StateSet>> label_states(const BranchingFormula& formula,
                                                                const rt::StateGraph& graph,
                                                                const Predecessors& predecessors, Bound bound,
                                                                const CancellationToken& cancellation);

/// Bytes that both bounds, the predecessors, the counters and a search for a run take.
[[nodiscard]] std::size_t bytes_of_labels(const BranchingFormula& formula, const rt::StateGraph& graph);

}  // namespace bip::verify
