// See weighted_sum.hpp.
#include "compiler/verify/invariants/weighted_sum.hpp"

#include <algorithm>
#include <map>

namespace bip::verify {

namespace {
// So many modes without weight are told one by one. More are "none of those that have one": one clause, and the solver
// sees what follows before it has decided which of them it is.
constexpr std::ptrdiff_t kFew = 1;
}  // namespace

bool build_weighted_sum(const Net& net, const TokenInvariant& invariant, const std::vector<std::uint8_t>& is_reachable,
                        WeightedSum& sum) {
  // By atom: each reachable mode and its weight. Modes are sorted, so those of an atom stand together.
  struct Level {
    std::vector<std::pair<u32, std::int64_t>> modes;  // kNoRow: all others
    std::int64_t least_left = 0, most_left = 0;       // of the atoms that follow
    u32 first_but = 0, but = 0;
  };
  sum = {1, {}, {}};
  std::vector<Level> levels;
  for (std::size_t k = 0; k < invariant.modes.size();) {
    const u32 atom = net.atom_of_mode[invariant.modes[k]];
    levels.emplace_back();
    Level& level = levels.back();
    std::size_t end = k;
    while (end < invariant.modes.size() && net.atom_of_mode[invariant.modes[end]] == atom) ++end;
    std::ptrdiff_t others =
        std::count(is_reachable.begin() + net.mode_base[atom], is_reachable.begin() + net.mode_base[atom + 1], 1);
    for (std::size_t in = k; in < end; ++in) others -= is_reachable[invariant.modes[in]];
    if (others > kFew) {
      level.first_but = static_cast<u32>(sum.buts.size());
      level.modes.emplace_back(kNoRow, 0);
      for (; k < end; ++k) {
        if (is_reachable[invariant.modes[k]] == 0) continue;
        level.modes.emplace_back(invariant.modes[k], weight_of(invariant, k));
        sum.buts.push_back(invariant.modes[k]);
      }
      level.but = static_cast<u32>(sum.buts.size()) - level.first_but;
      continue;
    }
    for (u32 mode = net.mode_base[atom]; mode < net.mode_base[atom + 1]; ++mode) {
      const bool is_in = k < end && invariant.modes[k] == mode;
      if (is_reachable[mode] != 0) level.modes.emplace_back(mode, is_in ? weight_of(invariant, k) : 0);
      if (is_in) ++k;
    }
  }
  std::int64_t least = 0, most = 0;
  for (std::size_t k = levels.size(); k-- > 0;) {
    levels[k].least_left = least;
    levels[k].most_left = most;
    if (levels[k].modes.empty()) return false;
    const auto [low, high] = std::minmax_element(levels[k].modes.begin(), levels[k].modes.end(),
                                                 [](const auto& a, const auto& b) { return a.second < b.second; });
    least += low->second;
    most += high->second;
  }
  std::map<std::int64_t, u32> nodes{{0, 0}};
  for (const Level& level : levels) {
    std::map<std::int64_t, u32> next;
    for (const auto& [value, node] : nodes) {
      for (const auto& [mode, weight] : level.modes) {
        const std::int64_t after = value + weight;
        u32 to = kNoRow;
        if (after + level.least_left <= invariant.total && invariant.total <= after + level.most_left) {
          const auto [found, is_new] = next.try_emplace(after, sum.nodes);
          sum.nodes += is_new ? 1 : 0;
          to = found->second;
        }
        sum.edges.push_back({node, to, mode, level.first_but, level.but});
      }
      if (sum.edges.size() > WeightedSum::kMaxEdges) return false;
    }
    nodes = std::move(next);
  }
  return true;
}

// A variable a node, which follows from the one before and the mode: what cannot become the total is excluded.
void add_weighted_sum(const WeightedSum& sum, const std::vector<Lit>& literals, Solver& solver, Lit on) {
  std::vector<Lit> nodes(sum.nodes, 0);
  for (u32 k = 1; k < sum.nodes; ++k) nodes[k] = solver.new_variable();
  std::vector<Lit> clause;
  for (const WeightedSum::Edge& edge : sum.edges) {
    clause.clear();
    if (edge.mode != kNoRow) clause.push_back(-literals[edge.mode]);
    for (u32 k = 0; edge.mode == kNoRow && k < edge.but; ++k) clause.push_back(literals[sum.buts[edge.first_but + k]]);
    if (on != 0) clause.push_back(-on);
    if (edge.node != 0) clause.push_back(-nodes[edge.node]);
    if (edge.next != kNoRow) clause.push_back(nodes[edge.next]);
    solver.add(clause);
  }
}

// From the end: a node is good if the mode that is marked leads to a good one.
Signal weighted_sum_signal(const WeightedSum& sum, const std::vector<Signal>& signals, Aig& aig) {
  std::vector<Signal> good(sum.nodes, kFalse);
  good.back() = kTrue;
  for (std::size_t k = sum.edges.size(); k-- > 0;) {
    const WeightedSum::Edge& edge = sum.edges[k];
    if (edge.next == kNoRow) continue;
    Signal on_edge = edge.mode == kNoRow ? kTrue : signals[edge.mode];
    for (u32 j = 0; edge.mode == kNoRow && j < edge.but; ++j)
      on_edge = aig.make_and(on_edge, negated(signals[sum.buts[edge.first_but + j]]));
    good[edge.node] = aig.make_or(good[edge.node], aig.make_and(on_edge, good[edge.next]));
  }
  return good[0];
}

}  // namespace bip::verify
