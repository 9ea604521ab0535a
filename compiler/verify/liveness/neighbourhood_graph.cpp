// See neighbourhood_graph.hpp.
#include "compiler/verify/liveness/neighbourhood_graph.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr std::size_t kMostCaseNodes = 1'000'000, kMostCaseEdges = 16'000'000;
constexpr u32 kCaseNodesBetweenLooks = 1024;

bool has(const std::vector<u32>& sorted, u32 atom) { return std::binary_search(sorted.begin(), sorted.end(), atom); }

}  // namespace

NeighbourhoodGraph::NeighbourhoodGraph(NeighbourhoodSteps& steps, const NamedPart& named,
                                       const std::vector<CaseNode>& nodes, const Neighbourhood& around,
                                       const std::vector<std::uint8_t>& is_finite, bool others_move)
    : steps_(steps), named_(named), case_(nodes), around_(around), is_finite_(is_finite), others_move_(others_move) {
  BIP_ASSERT(std::is_sorted(nodes.begin(), nodes.end()), "{} nodes of a case in no order", nodes.size());
  BIP_ASSERT(around.is_complete(), "not all moves of {} components", around.atoms().size());
}

bool NeighbourhoodGraph::build(const CancellationToken& cancellation) {
  const std::size_t nodes = case_.size() * around_.width();
  if (nodes > kMostCaseNodes) return false;
  for (u32 row = 0; row < case_.size(); ++row) add_edges_of_case(row);
  round_of_.assign(nodes, 0);
  taken_in_.assign(steps_.size(), 0);
  for (u32 node = 0; node < nodes; ++node) {
    if (node % kCaseNodesBetweenLooks == 0 && cancellation.is_over()) return false;
    first_edge_.push_back(static_cast<u32>(edges_.size()));
    add_edges(node);
    if (edges_.size() > kMostCaseEdges) return false;
  }
  first_edge_.push_back(static_cast<u32>(edges_.size()));
  return true;
}

void NeighbourhoodGraph::add_edges_of_case(u32 row) {
  const std::vector<u32>& states = case_[row].states;
  add_edges_to(row, kOtherStep, states, idle_.emplace_back());
  std::vector<Edge>& alone = alone_.emplace_back();
  if (others_move_) alone = idle_.back();
  for (const FollowedStep& step : around_.steps()) {
    if (!step.has_named || step.has_beside || is_finite_[step.step] != 0) continue;
    for_each_move(steps_, around_, step, states, 0,
                  [&](const std::vector<u32>& named, u32) { add_edges_to(row, step.step, named, alone); });
  }
}

void NeighbourhoodGraph::add_edges(u32 node) {
  const u32 width = around_.width(), row = node / width, combination = node % width;
  for (const Edge& edge : alone_[row]) edges_.push_back({edge.to * width + combination, edge.step, edge.marks});
  for (const Neighbourhood::Move& move : around_.moves(combination)) {
    if (is_finite_[move.step] != 0) continue;
    for (const Edge& edge : idle_[row]) edges_.push_back({edge.to * width + move.to, move.step, edge.marks});
  }
  for (const FollowedStep& step : around_.steps()) {
    if (!step.has_named || !step.has_beside || is_finite_[step.step] != 0) continue;
    for_each_move(steps_, around_, step, case_[row].states, combination, [&](const std::vector<u32>& named, u32 to) {
      joint_.clear();
      add_edges_to(row, step.step, named, joint_);
      for (const Edge& edge : joint_) edges_.push_back({edge.to * width + to, edge.step, edge.marks});
    });
  }
}

// To the nodes of the case that the automaton may go on to while the named components get these states.
void NeighbourhoodGraph::add_edges_to(u32 row, u32 step, const std::vector<u32>& named,
                                      std::vector<Edge>& edges) const {
  const Automaton& automaton = *named_.automaton;
  if (automaton.may_accept[case_[row].automaton] == 0) return;
  for_each_automaton_edge(named_, case_[row], step, [&](u32 state, u32 marks) {
    if (automaton.may_accept[state] == 0) return;
    const CaseNode to{state, named};
    const auto at = std::lower_bound(case_.begin(), case_.end(), to);
    if (at != case_.end() && *at == to) edges.push_back({static_cast<u32>(at - case_.begin()), step, marks});
  });
}

NeighbourhoodGraph::Repeated NeighbourhoodGraph::find_repeated(const Fairness& fairness) {
  find_units(fairness);
  Repeated found;
  found.steps.assign(steps_.size(), 0);
  std::vector<std::vector<u32>> todo(1, std::vector<u32>(round_of_.size()));
  std::iota(todo.back().begin(), todo.back().end(), 0u);
  struct Visitor {
    NeighbourhoodGraph& graph;
    std::vector<std::vector<u32>> components = {};
    u32 enter(u32 node) { return graph.first_edge_[node]; }
    u32 next(u32 node, u32& edge) {
      while (edge < graph.first_edge_[node + 1]) {
        const u32 to = graph.edges_[edge++].to;
        if (graph.round_of_[to] == graph.round_) return to;
      }
      return kNoSuccessor;
    }
    void reach(u32, u32) {}
    void close(const u32* nodes, std::size_t count) {
      // Mostly a node by itself, from which no edge leads back.
      if (count > 1 || graph.has_loop(*nodes)) components.emplace_back(nodes, nodes + count);
    }
  };
  while (!todo.empty()) {
    const std::vector<u32> nodes = std::move(todo.back());
    todo.pop_back();
    ++round_;
    for (const u32 node : nodes) round_of_[node] = round_;
    Visitor visitor{*this};
    search_.begin(round_of_.size());
    for (const u32 node : nodes) search_.visit(node, visitor);
    for (const std::vector<u32>& component : visitor.components) {
      std::vector<u32> rest = judge(component, found);
      if (!rest.empty()) todo.push_back(std::move(rest));
    }
  }
  return found;
}

bool NeighbourhoodGraph::has_loop(u32 node) const {
  const auto begin = edges_.begin() + static_cast<std::ptrdiff_t>(first_edge_[node]);
  const auto end = edges_.begin() + static_cast<std::ptrdiff_t>(first_edge_[node + 1]);
  return std::any_of(begin, end, [&](const Edge& edge) { return edge.to == node; });
}

// Those whose steps all take part in the neighbourhood.
void NeighbourhoodGraph::find_units(const Fairness& fairness) {
  units_.clear();
  for (const FairnessTerm& term : fairness.terms) {
    const auto add = [&](std::vector<u32> steps) { units_.push_back({term.is_strong(), std::move(steps)}); };
    switch (term.unit) {
      case FairnessUnit::Interactions:
        for (const FollowedStep& step : around_.steps()) {
          if (step.is_whole) add({step.step});
        }
        break;
      case FairnessUnit::Atoms:
        for (const u32 atom : around_.atoms()) add(steps_.steps_of(atom));
        break;
      case FairnessUnit::Connector:
        if (around_.find_whole(term.owner) != nullptr) add({term.owner});
        break;
      case FairnessUnit::Port: {
        if (!has(around_.atoms(), term.owner)) break;
        std::vector<u32> steps = steps_.steps_of(term.owner);
        std::erase_if(steps, [&](u32 step) { return steps_.port_of(step, term.owner) != term.port; });
        add(std::move(steps));
        break;
      }
      case FairnessUnit::Atom:
        if (has(around_.atoms(), term.owner)) add(steps_.steps_of(term.owner));
        break;
    }
  }
}

// Is some step of the unit possible for sure?
bool NeighbourhoodGraph::is_sure(const Unit& unit, u32 node) {
  const std::vector<u32>& named = case_[node / around_.width()].states;
  return std::any_of(unit.steps.begin(), unit.steps.end(), [&](u32 number) {
    const FollowedStep* const step = around_.find_whole(number);
    return step != nullptr && steps_.is_sure(number, around_.members_of(*step, named, node % around_.width()));
  });
}

std::vector<u32> NeighbourhoodGraph::judge(const std::vector<u32>& nodes, Repeated& found) {
  ++round_;
  for (const u32 node : nodes) round_of_[node] = round_;
  u32 marks = 0;
  std::vector<u32> taken;  // steps
  for (const u32 node : nodes) {
    for (u32 row = first_edge_[node]; row < first_edge_[node + 1]; ++row) {
      const Edge& edge = edges_[row];
      if (round_of_[edge.to] != round_) continue;
      marks |= edge.marks;
      if (edge.step == kOtherStep || taken_in_[edge.step] == round_) continue;
      taken_in_[edge.step] = round_;
      taken.push_back(edge.step);
    }
  }
  if (marks != named_.automaton->marks) return {};
  for (const Unit& unit : units_) {
    if (std::any_of(unit.steps.begin(), unit.steps.end(), [&](u32 step) { return taken_in_[step] == round_; }))
      continue;
    std::vector<u32> rest;
    for (const u32 node : nodes) {
      if (is_sure(unit, node)) continue;
      rest.push_back(node);
      if (!unit.is_strong) break;
    }
    // It is possible in each state, and has no turn.
    if (rest.empty()) return {};
    if (unit.is_strong && rest.size() < nodes.size()) return rest;
  }
  std::vector<u32> rows;  // of the case, which is sorted
  rows.reserve(nodes.size());
  for (const u32 node : nodes) rows.push_back(node / around_.width());
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  std::vector<CaseNode>& part = found.parts.emplace_back();
  for (const u32 row : rows) part.push_back(case_[row]);
  for (const u32 step : taken) found.steps[step] = 1;
  return {};
}

}  // namespace bip::verify
