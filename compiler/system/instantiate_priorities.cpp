// Priority rules of a compound instance, and what can be said of them before running: rules against maximal progress
// and cycles of rules without guards.
#include <algorithm>
#include <iterator>
#include <unordered_map>
#include <unordered_set>

#include "compiler/system/instantiator.hpp"
#include "compiler/system/system.hpp"
#include "runtime/core/graph_algorithms.hpp"

namespace bip::system {

// The connectors that a side of a rule may be about: one, or with [*] all elements; *:* is one without a row.
std::optional<std::vector<std::uint32_t>> Instantiator::pattern_connectors(std::uint32_t instance,
                                                                           const PatternPath& path,
                                                                           const std::vector<Value>& self) {
  if (path.any_connector) return std::vector<std::uint32_t>{Element::kHole};
  if (path.connector.star) {
    std::vector<std::uint32_t> rows = instances[instance].connectors[path.connector.family];
    std::erase(rows, Element::kHole);
    return rows;
  }
  const std::optional<std::uint32_t> row =
      find(instances[instance], path.connector, ElementKind::Connector, self, path.range);
  if (!row) return std::nullopt;
  return std::vector<std::uint32_t>{*row};
}

bool Instantiator::pattern(std::uint32_t instance, const PatternPath& path, std::uint32_t pending,
                           const std::vector<Value>& self, Pattern& to) {
  to.any_connector = path.any_connector;
  to.any_interaction = path.any_interaction;
  if (path.any_connector) return true;
  const PendingConnector& bound = instances[instance].pending[pending];
  to.connector = bound.id;
  if (path.any_interaction) return true;
  const Connector& connector = out.connectors[to.connector];
  const ConnectorType& type = model.connector_types[connector.type];
  for (const PatternPort& port : path.ports) {
    std::vector<PortRef> refs;
    if (port.param.empty() && !resolve_port(instance, port.path, self, refs, 0)) return false;
    std::uint32_t k = 0;
    while (k < type.params.size() && (port.param.empty() ? refs.size() != 1 || !(connector.ports[k] == refs[0])
                                                         : type.params[k].name != port.param))
      ++k;
    if (k == type.params.size()) {
      diags.report(Diag::kB3004, port.range, bound.name, model.sources->text(port.range));
      return false;
    }
    to.params.push_back(k);
  }
  std::sort(to.params.begin(), to.params.end());
  to.params.erase(std::unique(to.params.begin(), to.params.end()), to.params.end());
  if (!model::is_interaction(type, to.params)) {
    diags.report(Diag::kB3005, path.range, bound.name);
    return false;
  }
  return true;
}

// Those of loops are known when all connectors are: until then, only with which values of the loops' variables.
void Instantiator::declare_priority(std::uint32_t instance, const CompoundItem& item, const std::vector<Value>& self) {
  Instance& in = instances[instance];
  const PriorityRule& rule = model.compound_types[in.type].priorities[item.family];
  if (too_many(out.priorities.size() + in.priorities.size(), "priorities", item.range)) return;
  std::string name = rule.name;
  if (item.index.is_valid()) {
    const std::optional<Value> n = value(item.index, self, item.syntax->index->range);
    if (!n) return;
    name += fmt::format("[{}]", n->int_value);
  }
  in.priorities.push_back({item.family, std::move(name), self});
}

void Instantiator::priorities(std::uint32_t instance) {
  const std::vector<PriorityRule>& types = model.compound_types[instances[instance].type].priorities;
  std::vector<PendingPriority> pending = std::move(instances[instance].priorities);
  std::unordered_set<std::string> names;
  for (const PendingPriority& p : pending) {
    if (names.insert(p.name).second) continue;
    diags.report(Diag::kB4015, types[p.rule].range, p.name);
    return;
  }
  for (std::uint32_t r = 0; r < types.size(); ++r) {
    if (!types[r].in_loop) pending.push_back({r, types[r].name, instances[instance].params});
  }
  const std::size_t first = out.priorities.size();
  std::vector<const PriorityRule*> rules;
  for (const PendingPriority& p : pending) {
    const PriorityRule& rule = types[p.rule];
    Priority row{.name = p.name,
                 .parent = instances[instance].row,
                 .low = {},
                 .high = {},
                 .guard = rule.guard,
                 .data = {},
                 .loc = model.loc(rule.range)};
    if (!rule.values.empty()) row.guard = model::priority_guard(model, diags, rule, p.self);
    for (const DataPath& d : rule.data) {
      const std::optional<DataRef> ref = resolve_data(instance, d, p.self);
      if (!ref) return;
      row.data.push_back(*ref);
    }
    const auto lows = pattern_connectors(instance, rule.low, p.self);
    const auto highs = pattern_connectors(instance, rule.high, p.self);
    if (!lows || !highs) return;
    for (const std::uint32_t low : *lows) {
      for (const std::uint32_t high : *highs) {
        if (too_many(out.priorities.size(), "priorities", rule.range)) return;
        row.low = {};
        row.high = {};
        if (!pattern(instance, rule.low, low, p.self, row.low) || !pattern(instance, rule.high, high, p.self, row.high))
          return;
        out.priorities.push(row);
        rules.push_back(&rule);
      }
    }
  }
  check_priorities(first, rules);
  if (diags.has_errors() || check_cycle(instances[instance].row, first, rules, GuardedRules::Ignored)) return;
  // One word a type: its instances have the same rules.
  const syntax::Decl& decl = *model.compound_types[instances[instance].type].decl;
  if (!model::is_suppressed(decl.annotations, "compoundprioritycycle") &&
      warned_cycles.insert(instances[instance].type.value).second) {
    check_cycle(instances[instance].row, first, rules, GuardedRules::Followed);
  }
}

namespace {

/// `c:p < d:*` without its name and guard.
SourceRange compared(const PriorityRule& rule) {
  return {rule.low.range.file, rule.low.range.begin, rule.high.range.end};
}

bool contains(const std::vector<std::uint32_t>& big, const std::vector<std::uint32_t>& small) {
  return std::includes(big.begin(), big.end(), small.begin(), small.end());
}

std::vector<std::uint32_t> all_params(const ConnectorType& type) {
  std::vector<std::uint32_t> all(type.params.size());
  for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
  return all;
}

/// Is there an interaction, enabled or not, above which rule `r` puts something and that rule `s` puts below something?
struct Chains {
  const System& system;
  const IndexVector<ConnectorTypeId, ConnectorType>& types;

  [[nodiscard]] const ConnectorType& type(ConnectorId c) const { return types[system.connectors[c].type]; }
  // Parameters that an interaction below the pattern may use.
  [[nodiscard]] std::vector<std::uint32_t> upper(const Pattern& low) const {
    return low.any_interaction ? all_params(type(low.connector)) : low.params;
  }

  [[nodiscard]] bool holds(const Priority& r, const Priority& s) const {
    const Pattern& high = r.high;
    const Pattern& low = s.low;
    if (!high.any_connector && !low.any_connector) {
      if (high.connector != low.connector) return false;
      return high.any_interaction || contains(model::largest_interaction(type(low.connector), upper(low)), high.params);
    }
    if (high.any_connector && !low.any_connector) {  // r.high: all but r.low
      if (r.low.connector != low.connector) return true;
      if (r.low.any_interaction) return false;
      return !contains(r.low.params, model::largest_interaction(type(low.connector), upper(low)));
    }
    if (!high.any_connector) {  // s.low: all but s.high
      if (s.high.connector != high.connector) return true;
      if (s.high.any_interaction) return false;
      for (const std::uint32_t p : s.high.params) {  // an interaction above r.high without p
        std::vector<std::uint32_t> rest = all_params(type(high.connector));
        std::erase(rest, p);
        const std::vector<std::uint32_t> k = model::largest_interaction(type(high.connector), rest);
        if (!k.empty() && (high.any_interaction || contains(k, high.params))) return true;
      }
      return false;
    }
    for (std::size_t c = 0; c < system.connectors.size(); ++c) {  // some interaction in neither r.low nor s.high
      const Connector& connector = system.connectors[ConnectorId(c)];
      if (connector.parent != r.parent || ConnectorId(c) == r.low.connector || ConnectorId(c) == s.high.connector)
        continue;
      if (!types[connector.type].exports) return true;
    }
    return false;
  }
};

}  // namespace

void Instantiator::check_priorities(std::size_t first_rule, const std::vector<const PriorityRule*>& rules) {
  const auto row = [&](std::size_t i) -> const Priority& { return out.priorities[PriorityId(first_rule + i)]; };
  for (std::size_t i = 0; i < rules.size(); ++i) {
    const Priority& r = row(i);
    if (r.low.any_connector || r.high.any_connector || r.low.connector != r.high.connector || r.low.any_interaction ||
        r.high.any_interaction)
      continue;
    if (contains(r.low.params, r.high.params))
      diags.report(Diag::kB3007, compared(*rules[i]), r.name)
          .help("maximal progress always prefers the larger interaction");
    else if (contains(r.high.params, r.low.params)) diags.report(Diag::kB3008, compared(*rules[i]), r.name);
  }
}

// True if there is one. Without guards it is an error, with them it closes only if they hold: a warning.
bool Instantiator::check_cycle(CompoundId parent, std::size_t first_rule, const std::vector<const PriorityRule*>& rules,
                               GuardedRules guarded) {
  const bool with_guards = guarded == GuardedRules::Followed;
  const Chains chains{out, model.connector_types};
  const auto row = [&](std::size_t i) -> const Priority& { return out.priorities[PriorityId(first_rule + i)]; };
  // A rule can be followed
  // by those about the connector of its high side and by those that begin with `*:*`: a long chain stays linear.
  std::vector<std::size_t> wild;
  std::vector<std::size_t> all;
  std::vector<std::uint8_t> is_followed(rules.size(), 0);
  std::unordered_map<std::uint32_t, std::vector<std::size_t>> by_low;
  for (std::size_t i = 0; i < rules.size(); ++i) {
    if (row(i).guard.is_valid() &&
        (!with_guards || model::is_suppressed(rules[i]->annotations, "compoundprioritycycle")))
      continue;
    all.push_back(i);
    is_followed[i] = 1;
    (row(i).low.any_connector ? wild : by_low[row(i).low.connector.value]).push_back(i);
  }
  const auto may_follow = [&](std::size_t i) {
    if (row(i).high.any_connector) return all;
    std::vector<std::size_t> next;
    const auto found = by_low.find(row(i).high.connector.value);
    static const std::vector<std::size_t> kNone;
    const std::vector<std::size_t>& same = found == by_low.end() ? kNone : found->second;
    std::merge(same.begin(), same.end(), wild.begin(), wild.end(), std::back_inserter(next));
    return next;
  };
  struct Follower {
    std::vector<std::size_t> next;
    std::size_t at = 0;
  };
  const auto enter = [&](std::uint32_t rule) {
    return is_followed[rule] != 0 ? Follower{may_follow(rule)} : Follower{};
  };
  const auto next = [](std::uint32_t, Follower& cursor) {
    return cursor.at == cursor.next.size() ? kNoSuccessor : static_cast<std::uint32_t>(cursor.next[cursor.at++]);
  };
  const auto holds = [&](std::uint32_t i, std::uint32_t j) { return chains.holds(row(i), row(j)); };
  // Without the rule that closes a cycle there may be others: all are reported.
  bool has_cycle = false;
  for (;;) {
    const auto cycle = find_cycle(static_cast<std::uint32_t>(rules.size()), enter, next, holds);
    if (cycle.empty()) return has_cycle;
    has_cycle = true;
    const std::uint32_t closing = cycle.front().node;
    std::string names;
    for (const auto& on : cycle) names += row(on.node).name + " < ";
    auto d =
        diags.report(with_guards ? Diag::kB3014 : Diag::kB3006, compared(*rules[closing]), names + row(closing).name);
    d.note(fmt::format("in compound `{}`", out.compounds[parent].path));
    for (const auto& on : cycle) {
      if (on.node != closing) d.label(compared(*rules[on.node]), "");
    }
    if (with_guards)
      d.help(
          "write guards that exclude each other, or `@SuppressWarning(compoundprioritycycle)` before the compound "
          "type");
    is_followed[closing] = 0;
  }
}

}  // namespace bip::system
