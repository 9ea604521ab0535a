// The graph of a neighbourhood in one case: nodes of the case, each with every combination of local states of the
// components beside, and an edge for each step that stays in the case; and what can be repeated for ever in it.
//
// A step that no component of the neighbourhood takes part in is an edge, too: it changes the automaton of the property
// alone.
#pragma once
#include <cstdint>
#include <map>
#include <vector>

#include "compiler/verify/liveness/automaton.hpp"
#include "compiler/verify/liveness/neighbourhood.hpp"
#include "compiler/verify/property/fairness.hpp"
#include "runtime/core/graph_algorithms.hpp"

namespace bip::verify {

/// What the automaton sees of a position.
struct SeenConditions {
  std::uint64_t may_hold = 0, may_fail = 0;  // bit k: condition k on states
  friend bool operator==(const SeenConditions&, const SeenConditions&) = default;
};

/// A state of the automaton with the local states of the components that the property names.
struct CaseNode {
  u32 automaton = 0;
  std::vector<u32> states;  // by named component
  friend bool operator==(const CaseNode&, const CaseNode&) = default;
  friend auto operator<=>(const CaseNode&, const CaseNode&) = default;
};

/// The property's side of a neighbourhood: the same for all.
struct NamedPart {
  std::vector<u32> atoms;  // ascending
  const Automaton* automaton = nullptr;
  std::uint64_t of_states = 0;                      // bits of conditions on states; the others are on steps
  std::vector<std::uint64_t> happens;               // by step: bits of conditions on steps that it makes true
  std::map<std::vector<u32>, SeenConditions> seen;  // by local states of `atoms`
};

/// A step that no component of the neighbourhood takes part in, or none at all, after the run has ended.
inline constexpr u32 kOtherStep = ~u32{0};

/// Calls `see(automaton_state, marks)` for each edge of the automaton that a node may take with a step.
template <class See>
void for_each_automaton_edge(const NamedPart& named, const CaseNode& node, u32 step, const See& see) {
  const SeenConditions& seen = named.seen.at(node.states);
  const std::uint64_t happens = step == kOtherStep ? 0 : named.happens[step];
  for (const AutomatonEdge& edge : named.automaton->edges[node.automaton]) {
    const std::uint64_t may_be_true = seen.may_hold | happens;
    const std::uint64_t may_be_false = seen.may_fail | (~named.of_states & ~happens);
    if ((edge.required & ~may_be_true) == 0 && (edge.forbidden & ~may_be_false) == 0) see(edge.to, edge.marks);
  }
}

class NeighbourhoodGraph {
 public:
  /// The nodes of `nodes`, sorted, with all combinations of a complete neighbourhood. `is_finite`: by step.
  /// `others_move`: steps without the neighbourhood may go on for ever. All must outlive the graph.
  NeighbourhoodGraph(NeighbourhoodSteps& steps, const NamedPart& named, const std::vector<CaseNode>& nodes,
                     const Neighbourhood& around, const std::vector<std::uint8_t>& is_finite, bool others_move);

  /// Makes the nodes and edges. False: they are too many, or the time is over.
  [[nodiscard]] bool build(const CancellationToken& cancellation);

  struct Repeated {
    std::vector<std::vector<CaseNode>> parts;  // by fair strong component: nodes of the case, sorted, each once
    std::vector<std::uint8_t> steps;           // by step: on an edge of one of them
    [[nodiscard]] bool is_empty() const { return parts.empty(); }
  };
  /// What runs that are fair and accepted may repeat for ever.
  [[nodiscard]] Repeated find_repeated(const Fairness& fairness);

 private:
  struct Edge {
    u32 to = 0, step = 0, marks = 0;
  };
  // In an edge of the case `to` is a row of it.
  void add_edges_of_case(u32 row);
  void add_edges(u32 node);
  void add_edges_to(u32 row, u32 step, const std::vector<u32>& named, std::vector<Edge>& edges) const;
  // What is to have its turn: possible if some of the steps is, and taken with it. All take part in the neighbourhood.
  struct Unit {
    bool is_strong = false;
    std::vector<u32> steps;
  };
  void find_units(const Fairness& fairness);
  [[nodiscard]] bool has_loop(u32 node) const;
  // Of a strong component with edges, into `found`; the nodes that are left where strong fairness excludes some.
  std::vector<u32> judge(const std::vector<u32>& nodes, Repeated& found);
  [[nodiscard]] bool is_sure(const Unit& unit, u32 node);

  NeighbourhoodSteps& steps_;
  const NamedPart& named_;
  const std::vector<CaseNode>& case_;
  const Neighbourhood& around_;
  const std::vector<std::uint8_t>& is_finite_;
  bool others_move_;
  // By row of the case: what the automaton does in a step without the named components, and all edges of these alone.
  std::vector<std::vector<Edge>> idle_, alone_;
  std::vector<u32> first_edge_;  // by node
  std::vector<Edge> edges_;
  std::vector<Unit> units_;
  std::vector<u32> round_of_;  // by node: of the set of nodes that is searched
  std::vector<u32> taken_in_;  // by step: the round in which an edge had it
  std::vector<Edge> joint_;    // of one move
  u32 round_ = 0;
  StrongComponents<u32> search_;
};

}  // namespace bip::verify
