// States, alternatives, firing. Priorities and texts are in naive_order.cpp.
#include "tools/gen/naive.hpp"

#include <algorithm>

namespace bip::gen {
namespace {

std::vector<Choice> maximal(const std::vector<Choice>& all) {
  std::vector<Choice> result;
  for (const Choice& a : all) {
    bool dominated = std::any_of(all.begin(), all.end(), [&](const Choice& b) {
      return a.leaves.size() < b.leaves.size() &&
             std::includes(b.leaves.begin(), b.leaves.end(), a.leaves.begin(), a.leaves.end());
    });
    if (!dominated) result.push_back(a);
  }
  return result;
}

Lookup lookup_in(Values& vars) {
  return [&vars](const std::string&, const std::string& name) -> Value& { return vars.at(name); };
}

}  // namespace

NaiveEngine::NaiveEngine(const Description& model, std::size_t limit, std::uint64_t seed,
                         const std::map<std::string, std::uint64_t>& numbers)
    : model_(model), world_(build_world(model)) {
  for (std::size_t c = 0; c < world_.connectors.size(); ++c) {
    std::vector<Node> nodes = structural_interactions(world_, static_cast<int>(c), limit);
    if (nodes.size() > limit) too_large_ = true;
    if (world_.connectors[c].is_top_level()) nodes_.insert(nodes_.end(), nodes.begin(), nodes.end());
    if (too_large_ || nodes_.size() > limit) {
      too_large_ = true;
      return;
    }
  }
  states_.resize(world_.atoms.size());
  for (std::size_t a = 0; a < states_.size(); ++a) {
    const auto number = numbers.find(world_.atoms[a].path);
    states_[a].generator = first_of_generator(seed, number == numbers.end() ? 0 : number->second);
    initialise(a);
  }
}

bool NaiveEngine::is_final() const {
  for (std::size_t a = 0; a < states_.size(); ++a) {
    const std::vector<std::string>& finals = world_.atoms[a].type->finals;
    for (const std::string& place : states_[a].marking) {
      if (std::find(finals.begin(), finals.end(), place) == finals.end()) return false;
    }
  }
  return true;
}

void NaiveEngine::initialise(std::size_t atom) {
  const AtomType& type = *world_.atoms[atom].type;
  AtomState& state = states_[atom];
  state.vars = world_.atoms[atom].args;
  for (const Var& var : type.data) state.vars[var.name] = zero_of(var.type);
  Place code{.generator = &state.generator};
  for (const Var& var : type.data) {
    if (!var.init) continue;
    Value& target = state.vars[var.name];
    target = converted(evaluate(*var.init, gen::lookup_in(state.vars), code), target.type);
  }
  state.marking.insert(type.initial.begin(), type.initial.end());
  for (const Clock& clock : type.clocks) {
    state.clocks[clock.name].unit = clock.unit == "microsecond"   ? 1'000
                                    : clock.unit == "millisecond" ? 1'000'000
                                                                  : 1'000'000'000;
  }
  execute(type.initial_action, gen::lookup_in(state.vars), code);
  if (code.fault || !invariants_hold(state, type)) return trouble(Trouble::Sure);
  settle(atom);
}

/// Finds what is enabled; an internal transition goes first, and settles in turn.
void NaiveEngine::settle(std::size_t atom) {
  find_enabled(states_[atom], *world_.atoms[atom].type);
  if (trouble_ != Trouble::None || !states_[atom].enabled.contains("")) {
    depth_ = 0;
    return;
  }
  // Without end: the shrinker may have taken a guard away.
  if (++depth_ > 500) return trouble(Trouble::Possible);
  fire_transition(atom, "");
}

void NaiveEngine::find_enabled(AtomState& state, const AtomType& type) {
  state.enabled.clear();
  if (state.at_work != nullptr || state.busy_until > now_) return;
  for (const Transition& t : type.transitions) {
    const Port* port = find_named(type.ports, t.port);
    if (port != nullptr && !port->event.empty() && state.events[t.port].empty()) continue;
    if (!holds_at(state, t.when, now_)) continue;
    bool marked =
        std::all_of(t.from.begin(), t.from.end(), [&](const std::string& p) { return state.marking.contains(p); });
    if (!marked) continue;
    Place code{.is_const = true};
    bool holds = !t.guard || evaluate(*t.guard, gen::lookup_in(state.vars), code).i != 0;
    if (code.fault) trouble(Trouble::Possible);
    if (!holds) continue;
    // Two of one port are a run-time error. The generator makes none, but the shrinker may.
    if (state.enabled.contains(t.port)) trouble(Trouble::Possible);
    state.enabled[t.port] = &t;
  }
  if (!state.enabled.contains("")) hide_dominated(state, type);
}

bool NaiveEngine::invariants_hold(AtomState& state, const AtomType& type) {
  for (const Invariant& i : type.invariants) {
    if (!i.when.empty()) continue;
    std::set<std::string> places(i.places.begin(), i.places.end());
    bool concerns = i.scope == "at"
                        ? places == state.marking
                        : std::includes(state.marking.begin(), state.marking.end(), places.begin(), places.end());
    Place code{.is_const = true};
    if (concerns && (evaluate(i.condition, gen::lookup_in(state.vars), code).i == 0 || code.fault)) return false;
  }
  return true;
}

/// Priorities of an atom: a port below an enabled one, through any ports, is not enabled.
void NaiveEngine::hide_dominated(AtomState& state, const AtomType& type) {
  std::set<std::pair<std::string, std::string>> below;
  for (const AtomRule& rule : type.rules) {
    Place code{.is_const = true};
    const bool holds = !rule.guard || evaluate(*rule.guard, gen::lookup_in(state.vars), code).i != 0;
    if (code.fault) trouble(Trouble::Possible);  // before the value is believed: the core may look at the guard or not
    if (!holds) continue;
    for (const Port& low : type.ports) {
      for (const Port& high : type.ports) {
        bool low_fits = rule.low == "*" ? low.name != rule.high : low.name == rule.low;
        bool high_fits = rule.high == "*" ? high.name != rule.low : high.name == rule.high;
        if (low_fits && high_fits) below.emplace(low.name, high.name);
      }
    }
  }
  std::set<std::string> hidden;
  for (const auto& [port, transition] : state.enabled) {
    std::vector<std::string> work = {port};
    std::set<std::string> above;
    while (!work.empty()) {
      std::string at = work.back();
      work.pop_back();
      for (const auto& [low, high] : below) {
        if (low == at && above.insert(high).second) work.push_back(high);
      }
    }
    if (std::any_of(above.begin(), above.end(), [&](const std::string& q) { return state.enabled.contains(q); }))
      hidden.insert(port);
  }
  for (const std::string& port : hidden) state.enabled.erase(port);
}

void NaiveEngine::fire_transition(std::size_t atom, const std::string& port) {
  AtomState& state = states_[atom];
  const Transition& t = *state.enabled.at(port);
  for (const std::string& place : t.from) state.marking.erase(place);
  for (const std::string& place : t.to) state.marking.insert(place);
  if (auto waiting = state.events.find(port); waiting != state.events.end() && !waiting->second.empty()) {
    const Port& declared = *find_named(world_.atoms[atom].type->ports, port);
    for (std::size_t v = 0; v < declared.vars.size(); ++v) state.vars[declared.vars[v]] = waiting->second.front()[v];
    waiting->second.pop_front();
  }
  if (!port.empty()) state.busy_until = 0;
  if (t.budget == 0) return finish(atom, t);
  state.at_work = &t;
  state.returns = now_ + std::int64_t{t.budget} * 1'000'000;
  state.enabled.clear();
}

Lookup NaiveEngine::lookup_in(Choice& choice) {
  return [this, &choice](const std::string& scope, const std::string& name) -> Value& {
    if (scope.empty()) return choice.own[name];
    const WorldConnector& row = world_.connectors[static_cast<std::size_t>(choice.connector)];
    std::size_t p = 0;
    while (row.type->params[p].name != scope) ++p;
    const PortType& port_type = *find_named(model_.port_types, row.type->params[p].type);
    std::size_t v = 0;
    while (port_type.vars[v].name != name) ++v;
    Choice& part = choice.parts.at(static_cast<int>(p));
    if (part.connector < 0) {
      const AtomType& type = *world_.atoms[static_cast<std::size_t>(part.atom)].type;
      return states_[static_cast<std::size_t>(part.atom)].vars[find_named(type.ports, part.port)->vars[v]];
    }
    const ConnectorType& inner = *world_.connectors[static_cast<std::size_t>(part.connector)].type;
    return part.own[inner.export_vars[v]];
  };
}

/// Adds the choice if its guard holds, after its `up`.
void NaiveEngine::complete(Choice choice, std::vector<Choice>& result) {
  const ConnectorType& type = *world_.connectors[static_cast<std::size_t>(choice.connector)].type;
  for (const Var& var : type.data) {
    choice.own[var.name] = zero_of(var.type);
    Place code{.is_const = true};
    if (var.init) choice.own[var.name] = converted(evaluate(*var.init, lookup_in(choice), code), var.type);
  }
  for (const Clause& clause : type.clauses) {
    std::vector<int> params = clause.params;
    std::sort(params.begin(), params.end());
    if (params == choice.params) choice.clause = &clause;
  }
  if (choice.clause != nullptr) {
    Place code{.is_const = true};
    bool holds = !choice.clause->guard || evaluate(*choice.clause->guard, lookup_in(choice), code).i != 0;
    if (holds && !code.fault) execute(choice.clause->up, lookup_in(choice), code);
    if (code.fault) trouble(Trouble::Possible);
    if (!holds || code.fault) return;
  }
  result.push_back(std::move(choice));
}

/// The alternatives that a bound port offers now.
std::vector<Choice> NaiveEngine::options_of(const WorldPort& port) {
  std::vector<Choice> result;
  for (const WorldOption& option : port) {
    if (option.connector >= 0) {
      std::vector<Choice> inner = choices_of(option.connector);
      if (option.maximal_only) {
        inner = maximal(inner);
        // Rules of the compound hide some, whatever becomes of what hides them.
        const WorldConnector& below = world_.connectors[static_cast<std::size_t>(option.connector)];
        const int compound = below.compound;
        const bool has_rules =
            below.is_top_level() && std::any_of(world_.rules.begin(), world_.rules.end(),
                                                [&](const WorldRule& rule) { return rule.compound == compound; });
        if (has_rules) inner = unhidden(std::move(inner), offered_in(compound));
      }
      result.insert(result.end(), inner.begin(), inner.end());
    } else if (states_[static_cast<std::size_t>(option.atom)].enabled.contains(option.port)) {
      Choice choice;
      choice.atom = option.atom;
      choice.port = option.port;
      choice.leaves.insert({option.atom, option.port});
      result.push_back(choice);
    }
  }
  return result;
}

std::vector<Choice> NaiveEngine::choices_of(int connector) {
  const WorldConnector& row = world_.connectors[static_cast<std::size_t>(connector)];
  std::vector<Choice> result;
  for (const auto& set : expand(row.type->define)) {
    Choice base;
    base.connector = connector;
    base.params = set;
    std::vector<Choice> partial = {base};
    for (int p : set) {
      std::vector<Choice> next, options;
      if (!partial.empty()) options = options_of(row.ports[static_cast<std::size_t>(p)]);
      for (const Choice& choice : partial) {
        for (const Choice& option : options) {
          next.push_back(choice);
          next.back().leaves.insert(option.leaves.begin(), option.leaves.end());
          next.back().parts.emplace(p, option);
        }
      }
      partial = std::move(next);
    }
    for (Choice& choice : partial) complete(std::move(choice), result);
  }
  return result;
}

void NaiveEngine::fire(Choice choice) {
  fire_part(choice);
  if (trouble_ == Trouble::None) refuse_events();
}

/// An atom fires at once; a connector runs its `down`, then its ports in the order of its parameters.
void NaiveEngine::fire_part(Choice& choice) {
  if (trouble_ != Trouble::None) return;
  if (choice.connector < 0) return fire_transition(static_cast<std::size_t>(choice.atom), choice.port);
  Place code;
  if (choice.clause != nullptr) execute(choice.clause->down, lookup_in(choice), code);
  if (code.fault) return trouble(Trouble::Sure);
  for (int p : choice.params) fire_part(choice.parts.at(p));
}

}  // namespace bip::gen
