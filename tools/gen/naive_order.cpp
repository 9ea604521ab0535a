// Candidates: a search through the priority relation as compiler/docs/language_meaning.md (section 5) defines it,
// including interactions that are not enabled. And the name of a candidate.
#include <algorithm>

#include "tools/gen/naive.hpp"

namespace bip::gen {
namespace {

bool contains(const std::set<int>& big, const std::set<int>& small) {
  return std::includes(big.begin(), big.end(), small.begin(), small.end());
}
bool is_below(const Node& a, const Node& b) {
  return a.connector == b.connector && a.leaves.size() < b.leaves.size() &&
         std::includes(b.leaves.begin(), b.leaves.end(), a.leaves.begin(), a.leaves.end());
}

}  // namespace

bool NaiveEngine::matches(const WorldRule& rule, RuleSide side, const Node& node) const {
  const bool high = side == RuleSide::High;
  const WorldPattern& mine = high ? rule.high : rule.low;
  if (mine.connector < 0) {
    bool same_compound = world_.connectors[static_cast<std::size_t>(node.connector)].compound == rule.compound;
    return same_compound && !matches(rule, high ? RuleSide::Low : RuleSide::High, node);
  }
  if (mine.connector != node.connector) return false;
  if (mine.any_interaction) return true;
  return high ? contains(node.params, mine.params) : contains(mine.params, node.params);
}

std::vector<bool> NaiveEngine::active_rules() {
  std::vector<bool> active;
  for (const WorldRule& rule : world_.rules) {
    Place code{.is_const = true};
    bool holds = true;
    if (rule.source->guard) {
      Lookup lookup = [&](const std::string& scope, const std::string& name) -> Value& {
        const auto& [atom, var] = rule.data.at(scope + "." + name);
        return states_[static_cast<std::size_t>(atom)].vars[var];
      };
      holds = evaluate(*rule.source->guard, lookup, code).i != 0;
    }
    if (code.fault) trouble(Trouble::Possible);
    active.push_back(holds && !code.fault);
  }
  return active;
}

std::vector<Choice> NaiveEngine::offered_in(int compound) {
  std::vector<Choice> offered;
  for (std::size_t c = 0; c < world_.connectors.size(); ++c) {
    const WorldConnector& row = world_.connectors[c];
    if (compound < 0 ? row.type->exports : row.compound != compound || !row.is_top_level()) continue;
    for (Choice& choice : choices_of(static_cast<int>(c))) offered.push_back(std::move(choice));
  }
  return offered;
}

std::vector<Choice> NaiveEngine::unhidden(std::vector<Choice> choices, const std::vector<Choice>& enabled) {
  std::vector<bool> active = active_rules();
  auto node_of = [&](const Choice& choice) {
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      if (nodes_[n].connector == choice.connector && nodes_[n].leaves == choice.leaves) return n;
    }
    return nodes_.size();
  };
  std::set<std::size_t> enabled_nodes;
  for (const Choice& choice : enabled) enabled_nodes.insert(node_of(choice));

  std::vector<Choice> result;
  for (Choice& choice : choices) {
    // Everything above the choice, by search; it is hidden if something enabled is there.
    std::vector<std::size_t> work = {node_of(choice)};
    std::vector<bool> above(nodes_.size(), false), used(active.size(), false);
    bool hidden = false;
    while (!work.empty() && !hidden) {
      const Node& at = nodes_[work.back()];
      work.pop_back();
      std::vector<bool> rules(active.size(), false);
      for (std::size_t r = 0; r < active.size(); ++r) {
        rules[r] = active[r] && !used[r] && matches(world_.rules[r], RuleSide::Low, at);
        if (rules[r]) used[r] = true;
      }
      for (std::size_t n = 0; n < nodes_.size() && !hidden; ++n) {
        if (above[n]) continue;
        bool reached = is_below(at, nodes_[n]);
        for (std::size_t r = 0; r < active.size() && !reached; ++r)
          reached = rules[r] && matches(world_.rules[r], RuleSide::High, nodes_[n]);
        if (!reached) continue;
        above[n] = true;
        work.push_back(n);
        hidden = enabled_nodes.contains(n);
      }
    }
    if (!hidden) result.push_back(std::move(choice));
  }
  return result;
}

std::vector<Choice> NaiveEngine::candidates() {
  // Rules relate interactions of one compound: what hides a step may be one that is offered below another connector.
  std::vector<Choice> enabled = offered_in(-1), all = enabled;
  std::set<int> with_rules;
  for (const WorldRule& rule : world_.rules) with_rules.insert(rule.compound);
  for (const int compound : with_rules) {
    for (Choice& choice : offered_in(compound)) {
      if (world_.connectors[static_cast<std::size_t>(choice.connector)].type->exports) all.push_back(std::move(choice));
    }
  }
  std::vector<Choice> result = unhidden(std::move(enabled), all);

  for (std::size_t a = 0; a < states_.size(); ++a) {
    for (const Port& port : world_.atoms[a].type->ports) {
      if (port.exported || !states_[a].enabled.contains(port.name)) continue;
      Choice choice;
      choice.atom = static_cast<int>(a);
      choice.port = port.name;
      result.push_back(choice);
    }
  }
  return result;
}

std::string NaiveEngine::key_of(const Choice& choice) const {
  if (choice.connector < 0) return world_.atoms[static_cast<std::size_t>(choice.atom)].path + "." + choice.port;
  std::set<std::string> leaves;
  for (const auto& [atom, port] : choice.leaves)
    leaves.insert(world_.atoms[static_cast<std::size_t>(atom)].path + "." + port);
  std::string text = world_.connectors[static_cast<std::size_t>(choice.connector)].path + ":";
  for (const std::string& leaf : leaves) text += " " + leaf;
  return text;
}

}  // namespace bip::gen
