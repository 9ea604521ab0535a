// See relevance_oracle.hpp.
#include "tests/verify/relevance_oracle.hpp"

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "compiler/verify/evidence/relevant_steps.hpp"
#include "runtime/core/final_state.hpp"

namespace bip::verify::test {

namespace {

using Choices = std::vector<std::uint64_t>;
using Ports = std::vector<std::pair<u32, u32>>;

bool is_bad(const rt::Core& core, const SearchGoal& goal) {
  return (goal.stuck && rt::is_deadlock(core)) || (goal.state && goal.state(core));
}

Ports ports_of(rt::Core& core, std::uint64_t choice) {
  std::vector<rt::Participant> participants;
  const rt::Candidate candidate = core.candidate(choice);
  core.participants(candidate, participants);
  Ports ports{{candidate.interaction.value, 0}};
  for (const rt::Participant& p : participants) ports.emplace_back(p.atom, p.port);
  std::sort(ports.begin() + 1, ports.end());
  return ports;
}

Choices walk(const rt::Image& image, const SearchGoal& goal, std::uint64_t seed) {
  constexpr int kWalks = 8;
  constexpr std::size_t kSteps = 60;
  std::mt19937_64 draw(seed);
  for (int k = 0; k < kWalks; ++k) {
    rt::Core core(image);
    Choices choices;
    if (!core.initialize()) return {};
    while (choices.size() < kSteps && core.candidate_count() != 0 && !is_bad(core, goal)) {
      choices.push_back(draw() % core.candidate_count());
      if (core.fire(choices.back())) continue;
      if (goal.faults) return choices;
      choices.clear();
      break;
    }
    if (!choices.empty() && !core.fault() && is_bad(core, goal)) return choices;
  }
  return {};
}

// Does the run without step `left_out` reach the goal, by the same ports?
bool goes_without(const rt::Image& image, const SearchGoal& goal, const std::vector<Ports>& steps,
                  std::size_t left_out) {
  rt::Core core(image);
  if (!core.initialize()) return false;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    if (k == left_out) continue;
    std::uint64_t choice = 0;
    while (choice < core.candidate_count() && ports_of(core, choice) != steps[k]) ++choice;
    if (choice == core.candidate_count()) return false;
    if (!core.fire(choice)) return goal.faults;
  }
  return is_bad(core, goal);
}

// All states that are not the goal's, with their edges to such.
struct Graph {
  struct Edge {
    u32 to;
    bool touches;  // an atom of the run
  };
  std::map<std::string, u32> rows;
  std::vector<std::vector<Edge>> edges;
  std::vector<bool> is_end, offers_run;  // by state; offers a step that touches an atom of the run
  bool has_errors = false, is_whole = true;
};

Graph graph_of(const rt::Image& image, const SearchGoal& goal, const std::set<u32>& atoms, std::size_t limit) {
  Graph graph;
  rt::Core core(image);
  if (!core.initialize() || is_bad(core, goal)) return graph;
  std::vector<rt::State> states{core.snapshot()};
  graph.rows[state_key(states[0])] = 0;
  for (u32 row = 0; row < states.size(); ++row) {
    if (states.size() > limit) {
      graph.is_whole = false;
      return graph;
    }
    graph.edges.emplace_back();
    (void)core.restore(states[row]);
    const std::uint64_t count = core.candidate_count();
    graph.is_end.push_back(count == 0);
    graph.offers_run.push_back(false);
    for (std::uint64_t choice = 0; choice < count; ++choice) {
      (void)core.restore(states[row]);
      const Ports ports = ports_of(core, choice);
      const bool touches =
          std::any_of(ports.begin() + 1, ports.end(), [&](const auto& p) { return atoms.contains(p.first); });
      if (touches) graph.offers_run[row] = true;
      if (!core.fire(choice)) {
        graph.has_errors = graph.has_errors || !goal.faults;
        continue;
      }
      if (is_bad(core, goal)) continue;
      const auto [found, is_new] = graph.rows.try_emplace(state_key(core.snapshot()), static_cast<u32>(states.size()));
      if (is_new) states.push_back(core.snapshot());
      graph.edges[row].push_back({found->second, touches});
    }
  }
  return graph;
}

std::vector<bool> reached_from(const Graph& graph, u32 row) {
  std::vector<bool> is_reached(graph.edges.size());
  std::vector<u32> open{row};
  is_reached[row] = true;
  while (!open.empty()) {
    const u32 at = open.back();
    open.pop_back();
    for (const Graph::Edge& edge : graph.edges[at]) {
      if (is_reached[edge.to]) continue;
      is_reached[edge.to] = true;
      open.push_back(edge.to);
    }
  }
  return is_reached;
}

// By state: can the goal be avoided from it? A way for ever has an edge that touches an atom of the run, or leaves a
// state in which these can do nothing.
std::vector<bool> avoidable(const Graph& graph) {
  std::vector<std::vector<bool>> reach;
  for (u32 row = 0; row < graph.edges.size(); ++row) reach.push_back(reached_from(graph, row));
  std::vector<bool> stays(graph.is_end);
  for (u32 row = 0; row < graph.edges.size(); ++row) {
    const std::vector<Graph::Edge>& edges = graph.edges[row];
    for (const Graph::Edge& edge : edges) {
      if ((edge.touches || !graph.offers_run[row]) && reach[edge.to][row]) stays[row] = true;
    }
  }
  std::vector<bool> is_avoidable(graph.edges.size());
  for (u32 row = 0; row < graph.edges.size(); ++row) {
    for (u32 to = 0; to < graph.edges.size(); ++to)
      if (reach[row][to] && stays[to]) is_avoidable[row] = true;
  }
  return is_avoidable;
}

}  // namespace

std::string check_relevance(const rt::Image& image, const SearchGoal& goal, std::uint64_t seed, std::size_t states,
                            RelevanceCounts& counts) {
  const Choices run = walk(image, goal, seed);
  if (run.empty()) return {};
  ++counts.runs;
  const CancellationToken token;
  const Choices needed = relevant_steps(image, goal, run, token);
  if (!reaches(image, goal, needed)) return "the steps that are left do not reach the goal";
  if (needed.size() > run.size()) return "there are more steps than before";
  counts.left_out += run.size() - needed.size();

  rt::Core core(image);
  (void)core.initialize();
  std::vector<Ports> steps;
  std::vector<std::string> keys;
  std::set<u32> atoms;
  bool has_choice = false;
  for (const std::uint64_t choice : needed) {
    has_choice = has_choice || core.candidate_count() > 1;
    keys.push_back(state_key(core.snapshot()));
    steps.push_back(ports_of(core, choice));
    for (auto port = steps.back().begin() + 1; port != steps.back().end(); ++port) atoms.insert(port->first);
    if (!core.fire(choice)) break;
  }
  for (std::size_t k = 0; k < steps.size(); ++k)
    if (goes_without(image, goal, steps, k)) return "step " + std::to_string(k) + " could be left out";

  const Graph graph = graph_of(image, goal, atoms, states);
  const std::optional<DecidingStep> decided = deciding_step(image, goal, needed, token);
  if (!graph.is_whole || graph.edges.empty()) return {};
  const std::vector<bool> is_avoidable = avoidable(graph);
  std::size_t last = 0;  // 1 + the last state of the run with a way out
  for (std::size_t k = 0; k < keys.size(); ++k)
    if (is_avoidable[graph.rows.at(keys[k])]) last = k + 1;
  if (!decided) return graph.has_errors || !has_choice ? "" : "it is not said which step decided";
  if (!has_choice) return "a run without choices has a step that decided";
  if (decided->way_out.empty() != (last == 0)) return last == 0 ? "a way out is told" : "no way out is told";
  if (last != 0 && decided->step + 1 != last)
    return "step " + std::to_string(decided->step) + " is said to decide, step " + std::to_string(last - 1) + " does";
  ++(last == 0 ? counts.inevitable : counts.decided);
  return {};
}

}  // namespace bip::verify::test
