// See product.hpp.
#include "compiler/verify/liveness/product.hpp"

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

Product::Product(const rt::StateGraph& graph, const Automaton& automaton, const Formula& formula)
    : graph_(graph), automaton_(automaton), width_(static_cast<std::uint32_t>(automaton.edges.size())) {
  BIP_ASSERT(!automaton.is_empty() && fits(graph.states(), automaton), "{} states, {} of the automaton", graph.states(),
             width_);
  const std::size_t conditions = formula.states.size();
  const std::uint64_t of_states = first_conditions(conditions);
  for (std::uint32_t value = 0; value < graph.valuations(); ++value) {
    const std::uint64_t holds = graph.valuation(value);
    for (const std::vector<AutomatonEdge>& edges : automaton.edges) {
      Slice slice{static_cast<std::uint32_t>(matches_.size()), 0};
      for (AutomatonEdge edge : edges) {
        if ((edge.required & of_states & ~holds) != 0 || (edge.forbidden & of_states & holds) != 0) continue;
        edge.required &= ~of_states;
        edge.forbidden &= ~of_states;
        matches_.push_back(edge);
      }
      slice.end = static_cast<std::uint32_t>(matches_.size());
      slices_.push_back(slice);
    }
  }
  for (std::uint32_t state = 0; state < width_; ++state)
    is_decided_.push_back(automaton.accepts_whatever_follows(state) ? 1 : 0);
  BIP_ASSERT(slices_.size() == std::size_t{graph.valuations()} * width_, "{} slices of {} valuations", slices_.size(),
             graph.valuations());
  const rt::StepLabels& labels = graph.labels();
  for (std::uint32_t label = 0; label < labels.size(); ++label)
    happens_.push_back(happens(formula, labels, label) << conditions);
}

std::uint64_t happens(const Formula& formula, const rt::StepLabels& labels, std::uint32_t label) {
  std::uint64_t holds = 0;
  for (std::size_t k = 0; k < formula.steps.size(); ++k) {
    const StepCondition& step = formula.steps[k];
    const bool is =
        step.is_port ? labels.has_port(label, {step.owner, step.port}) : labels[label].connector == step.owner;
    if (is) holds |= std::uint64_t{1} << k;
  }
  return holds;
}

}  // namespace bip::verify
