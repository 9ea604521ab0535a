// States, alternatives, firing. Priorities and texts are in naive_order.cpp.
#include "tools/gen/naive.hpp"

#include <algorithm>

namespace bip::gen {
namespace {

std::vector<Choice> maximal(const std::vector<Choice>& all) {
  std::vector<Choice> result;
  for (const Choice& a : all) {
    bool dominated = std::any_of(all.begin(), all.end(), [&](const Choice& b) {
      return a.leaves.size() < b.leaves.size() && std::includes(b.leaves.begin(), b.leaves.end(), a.leaves.begin(), a.leaves.end());
    });
    if (!dominated) result.push_back(a);
  }
  return result;
}

Lookup lookup_in(Values& vars) {
  return [&vars](const std::string&, const std::string& name) -> Value& { return vars.at(name); };
}

}  // namespace

NaiveEngine::NaiveEngine(const Description& model, std::size_t limit) : model_(model), world_(build_world(model)) {
  for (std::size_t c = 0; c < world_.connectors.size(); ++c) {
    std::vector<Node> nodes = structural_interactions(world_, static_cast<int>(c), limit);
    if (nodes.size() > limit) too_large_ = true;
    if (!world_.connectors[c].type->exports) nodes_.insert(nodes_.end(), nodes.begin(), nodes.end());
    if (too_large_ || nodes_.size() > limit) {
      too_large_ = true;
      return;
    }
  }
  states_.resize(world_.atoms.size());
  for (std::size_t a = 0; a < states_.size(); ++a) initialise(a);
}

void NaiveEngine::initialise(std::size_t atom) {
  const AtomType& type = *world_.atoms[atom].type;
  AtomState& state = states_[atom];
  state.vars = world_.atoms[atom].args;
  for (const Var& var : type.data) state.vars[var.name] = zero_of(var.type);
  bool fault = false;
  for (const Var& var : type.data) {
    if (!var.init) continue;
    Value& target = state.vars[var.name];
    target = converted(evaluate(*var.init, gen::lookup_in(state.vars), fault), target.type);
  }
  state.marking.insert(type.initial.begin(), type.initial.end());
  execute(type.initial_action, gen::lookup_in(state.vars), fault);
  if (fault) trouble(Trouble::Sure);
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
  for (const Transition& t : type.transitions) {
    bool marked = std::all_of(t.from.begin(), t.from.end(), [&](const std::string& p) { return state.marking.contains(p); });
    if (!marked) continue;
    bool fault = false;
    bool holds = !t.guard || evaluate(*t.guard, gen::lookup_in(state.vars), fault).i != 0;
    if (fault) trouble(Trouble::Possible);
    if (!holds) continue;
    // Two of one port are a run-time error. The generator makes none, but the shrinker may.
    if (state.enabled.contains(t.port)) trouble(Trouble::Possible);
    state.enabled[t.port] = &t;
  }
}

void NaiveEngine::fire_transition(std::size_t atom, const std::string& port) {
  AtomState& state = states_[atom];
  const Transition& t = *state.enabled.at(port);
  for (const std::string& place : t.from) state.marking.erase(place);
  for (const std::string& place : t.to) state.marking.insert(place);
  bool fault = false;
  execute(t.action, gen::lookup_in(state.vars), fault);
  if (fault) {
    trouble(Trouble::Sure);
    return;
  }
  settle(atom);
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
    const WorldPort& port = row.ports[p];
    if (port.atom >= 0) {
      const AtomType& type = *world_.atoms[static_cast<std::size_t>(port.atom)].type;
      return states_[static_cast<std::size_t>(port.atom)].vars[find_named(type.ports, port.port)->vars[v]];
    }
    const ConnectorType& inner = *world_.connectors[static_cast<std::size_t>(port.connector)].type;
    return choice.nested.at(static_cast<int>(p)).own[inner.export_vars[v]];
  };
}

/// Adds the choice if its guard holds, after its `up`.
void NaiveEngine::complete(Choice choice, std::vector<Choice>& result) {
  const ConnectorType& type = *world_.connectors[static_cast<std::size_t>(choice.connector)].type;
  for (const Var& var : type.data) choice.own[var.name] = zero_of(var.type);
  for (const Clause& clause : type.clauses) {
    std::vector<int> params = clause.params;
    std::sort(params.begin(), params.end());
    if (params == choice.params) choice.clause = &clause;
  }
  if (choice.clause != nullptr) {
    bool fault = false;
    bool holds = !choice.clause->guard || evaluate(*choice.clause->guard, lookup_in(choice), fault).i != 0;
    if (holds && !fault) execute(choice.clause->up, lookup_in(choice), fault);
    if (fault) trouble(Trouble::Possible);
    if (!holds || fault) return;
  }
  result.push_back(std::move(choice));
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
      const WorldPort& port = row.ports[static_cast<std::size_t>(p)];
      std::vector<Choice> next;
      if (port.atom >= 0) {
        if (states_[static_cast<std::size_t>(port.atom)].enabled.contains(port.port)) next = partial;
        for (Choice& choice : next) choice.leaves.insert({port.atom, port.port});
      } else if (!partial.empty()) {
        std::vector<Choice> inner = choices_of(port.connector);
        if (port.maximal_only) inner = maximal(inner);
        for (const Choice& choice : partial) {
          for (const Choice& alternative : inner) {
            next.push_back(choice);
            next.back().leaves.insert(alternative.leaves.begin(), alternative.leaves.end());
            next.back().nested.emplace(p, alternative);
          }
        }
      }
      partial = std::move(next);
    }
    for (Choice& choice : partial) complete(std::move(choice), result);
  }
  return result;
}

void NaiveEngine::fire_connector(Choice& choice) {
  const WorldConnector& row = world_.connectors[static_cast<std::size_t>(choice.connector)];
  bool fault = false;
  if (choice.clause != nullptr) execute(choice.clause->down, lookup_in(choice), fault);
  if (fault) {
    trouble(Trouble::Sure);
    return;
  }
  for (int p : choice.params) {
    if (trouble_ != Trouble::None) return;
    const WorldPort& port = row.ports[static_cast<std::size_t>(p)];
    if (port.atom >= 0) {
      fire_transition(static_cast<std::size_t>(port.atom), port.port);
    } else {
      fire_connector(choice.nested.at(p));
    }
  }
}

void NaiveEngine::fire(Choice choice) {
  if (choice.connector >= 0) {
    fire_connector(choice);
  } else {
    fire_transition(static_cast<std::size_t>(choice.atom), choice.port);
  }
}

}  // namespace bip::gen
