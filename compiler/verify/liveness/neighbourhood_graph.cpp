// See neighbourhood_graph.hpp.
#include "compiler/verify/liveness/neighbourhood_graph.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr std::size_t kMostCaseNodes = 1'000'000, kMostCaseEdges = 16'000'000;
constexpr u32 kCaseNodesBetweenLooks = 1024;

bool has(const std::vector<u32>& sorted, u32 atom) { return std::binary_search(sorted.begin(), sorted.end(), atom); }
std::size_t row_of(const std::vector<u32>& sorted, u32 atom) {
  const auto at = std::lower_bound(sorted.begin(), sorted.end(), atom);
  BIP_ASSERT(at != sorted.end() && *at == atom, "component {} is not among {}", atom, sorted.size());
  return static_cast<std::size_t>(at - sorted.begin());
}

}  // namespace

BesideMoves::BesideMoves(NeighbourhoodSteps& steps, const std::vector<u32>& named, std::vector<u32> beside,
                         const CancellationToken& cancellation)
    : atoms_(std::move(beside)) {
  BIP_ASSERT(std::is_sorted(atoms_.begin(), atoms_.end()), "{} components in no order", atoms_.size());
  is_complete_ = find_moves(steps, named, cancellation);
}

bool BesideMoves::find_moves(NeighbourhoodSteps& steps, const std::vector<u32>& named,
                             const CancellationToken& cancellation) {
  std::set<u32> own;
  for (const u32 atom : atoms_) {
    const LocalSpace* space = steps.space(atom, cancellation);
    BIP_ASSERT(space != nullptr, "component {} has no space", atom);
    if (space->size() > kMostCaseNodes / width_) return false;
    sizes_.push_back(space->size());
    strides_.push_back(width_);
    width_ *= space->size();
    own.insert(steps.steps_of(atom).begin(), steps.steps_of(atom).end());
  }
  std::erase_if(own, [&](u32 step) {
    const std::vector<u32>& all = steps.atoms_of(step);
    return std::any_of(all.begin(), all.end(), [&](u32 atom) { return has(named, atom); });
  });
  std::vector<std::size_t> rows;
  for (u32 from = 0; from < width_; ++from) {
    if (from % kCaseNodesBetweenLooks == 0 && cancellation.is_over()) return false;
    first_.push_back(static_cast<u32>(moves_.size()));
    for (const u32 step : own) {
      NeighbourhoodSteps::Members members;
      rows.clear();
      for (const u32 atom : steps.atoms_of(step)) {
        if (!has(atoms_, atom)) continue;
        rows.push_back(row_of(atoms_, atom));
        members.add({atom, state_of(rows.back(), from)});
      }
      for (const NeighbourhoodSteps::Move& move : steps.moves(step, members)) {
        u32 to = from;
        for (std::size_t k = 0; k < rows.size(); ++k) {
          // Spaces have all states from the start; one that has not is of no use.
          if (move[k] >= sizes_[rows[k]]) return false;
          to = with(rows[k], move[k], to);
        }
        moves_.push_back({step, to});
      }
    }
    if (moves_.size() > kMostCaseEdges) return false;
  }
  first_.push_back(static_cast<u32>(moves_.size()));
  return true;
}

NeighbourhoodGraph::NeighbourhoodGraph(NeighbourhoodSteps& steps, const NamedPart& named,
                                       const std::vector<CaseNode>& nodes, const BesideMoves& beside,
                                       const std::vector<std::uint8_t>& is_finite, bool others_move)
    : steps_(steps),
      named_(named),
      case_(nodes),
      beside_(beside),
      is_finite_(is_finite),
      others_move_(others_move),
      atoms_(named.atoms) {
  BIP_ASSERT(std::is_sorted(nodes.begin(), nodes.end()), "{} nodes of a case in no order", nodes.size());
  BIP_ASSERT(beside.is_complete(), "not all moves of {} components", beside.atoms().size());
  atoms_.insert(atoms_.end(), beside.atoms().begin(), beside.atoms().end());
  std::sort(atoms_.begin(), atoms_.end());
  std::set<u32> followed;
  for (const u32 atom : atoms_) followed.insert(steps.steps_of(atom).begin(), steps.steps_of(atom).end());
  for (const u32 step : followed) {
    const std::vector<u32>& all = steps.atoms_of(step);
    const bool is_named = std::any_of(all.begin(), all.end(), [&](u32 atom) { return has(named.atoms, atom); });
    const bool is_beside = std::any_of(all.begin(), all.end(), [&](u32 atom) { return has(beside.atoms(), atom); });
    if (is_named && is_finite[step] == 0) (is_beside ? joint_steps_ : named_steps_).push_back(step);
    if (std::all_of(all.begin(), all.end(), [&](u32 atom) { return has(atoms_, atom); })) whole_.push_back(step);
  }
}

bool NeighbourhoodGraph::build(const CancellationToken& cancellation) {
  const std::size_t nodes = case_.size() * beside_.width();
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

u32 NeighbourhoodGraph::state_of(u32 atom, u32 node) const {
  if (has(named_.atoms, atom)) return case_[node / beside_.width()].states[row_of(named_.atoms, atom)];
  return beside_.state_of(row_of(beside_.atoms(), atom), node % beside_.width());
}

NeighbourhoodSteps::Members NeighbourhoodGraph::members_of(u32 step, u32 node) const {
  NeighbourhoodSteps::Members members;
  for (const u32 atom : steps_.atoms_of(step)) {
    if (has(atoms_, atom)) members.add({atom, state_of(atom, node)});
  }
  return members;
}

void NeighbourhoodGraph::add_edges_of_case(u32 row) {
  const std::vector<u32>& states = case_[row].states;
  add_edges_to(row, kOtherStep, states, idle_.emplace_back());
  std::vector<Edge>& alone = alone_.emplace_back();
  if (others_move_) alone = idle_.back();
  for (const u32 step : named_steps_) {
    const NeighbourhoodSteps::Members members = members_of(step, row * beside_.width());
    for (const NeighbourhoodSteps::Move& move : steps_.moves(step, members)) {
      std::vector<u32> named = states;
      for (std::size_t k = 0; k < members.size(); ++k) named[row_of(named_.atoms, members[k].atom)] = move[k];
      add_edges_to(row, step, named, alone);
    }
  }
}

void NeighbourhoodGraph::add_edges(u32 node) {
  const u32 width = beside_.width(), row = node / width, combination = node % width;
  for (const Edge& edge : alone_[row]) edges_.push_back({edge.to * width + combination, edge.step, edge.marks});
  for (const BesideMoves::Move& move : beside_.of(combination)) {
    if (is_finite_[move.step] != 0) continue;
    for (const Edge& edge : idle_[row]) edges_.push_back({edge.to * width + move.to, move.step, edge.marks});
  }
  std::vector<Edge> joint;
  for (const u32 step : joint_steps_) {
    const NeighbourhoodSteps::Members members = members_of(step, node);
    for (const NeighbourhoodSteps::Move& move : steps_.moves(step, members)) {
      std::vector<u32> named = case_[row].states;
      u32 to = combination;
      for (std::size_t k = 0; k < members.size(); ++k) {
        const u32 atom = members[k].atom;
        if (has(named_.atoms, atom)) named[row_of(named_.atoms, atom)] = move[k];
        else to = beside_.with(row_of(beside_.atoms(), atom), move[k], to);
      }
      joint.clear();
      add_edges_to(row, step, named, joint);
      for (const Edge& edge : joint) edges_.push_back({edge.to * width + to, step, edge.marks});
    }
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
  std::vector<std::vector<u32>> todo(1);
  for (u32 node = 0; node < round_of_.size(); ++node) todo.back().push_back(node);
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
    void close(const u32* nodes, std::size_t count) { components.emplace_back(nodes, nodes + count); }
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

// Those whose steps all take part in the neighbourhood.
void NeighbourhoodGraph::find_units(const Fairness& fairness) {
  units_.clear();
  for (const FairnessTerm& term : fairness.terms) {
    const auto add = [&](std::vector<u32> steps) { units_.push_back({term.is_strong(), std::move(steps)}); };
    switch (term.unit) {
      case FairnessUnit::Interactions:
        for (const u32 step : whole_) add({step});
        break;
      case FairnessUnit::Atoms:
        for (const u32 atom : atoms_) add(steps_.steps_of(atom));
        break;
      case FairnessUnit::Connector:
        if (has(whole_, term.owner)) add({term.owner});
        break;
      case FairnessUnit::Port: {
        if (!has(atoms_, term.owner)) break;
        std::vector<u32> steps = steps_.steps_of(term.owner);
        std::erase_if(steps, [&](u32 step) { return steps_.port_of(step, term.owner) != term.port; });
        add(std::move(steps));
        break;
      }
      case FairnessUnit::Atom:
        if (has(atoms_, term.owner)) add(steps_.steps_of(term.owner));
        break;
    }
  }
}

// Is some step of the unit possible for sure?
bool NeighbourhoodGraph::is_sure(const Unit& unit, u32 node) {
  return std::any_of(unit.steps.begin(), unit.steps.end(),
                     [&](u32 step) { return has(whole_, step) && steps_.is_sure(step, members_of(step, node)); });
}

std::vector<u32> NeighbourhoodGraph::judge(const std::vector<u32>& nodes, Repeated& found) {
  ++round_;
  for (const u32 node : nodes) round_of_[node] = round_;
  u32 marks = 0;
  std::vector<u32> taken;  // steps
  bool has_edges = false;
  for (const u32 node : nodes) {
    for (u32 row = first_edge_[node]; row < first_edge_[node + 1]; ++row) {
      const Edge& edge = edges_[row];
      if (round_of_[edge.to] != round_) continue;
      has_edges = true;
      marks |= edge.marks;
      if (edge.step == kOtherStep || taken_in_[edge.step] == round_) continue;
      taken_in_[edge.step] = round_;
      taken.push_back(edge.step);
    }
  }
  if (!has_edges || marks != named_.automaton->marks) return {};
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
  std::vector<CaseNode>& part = found.parts.emplace_back();
  for (const u32 node : nodes) part.push_back(case_[node / beside_.width()]);
  std::sort(part.begin(), part.end());
  part.erase(std::unique(part.begin(), part.end()), part.end());
  for (const u32 step : taken) found.steps[step] = 1;
  return {};
}

}  // namespace bip::verify
