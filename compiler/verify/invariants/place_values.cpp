// See place_values.hpp. Values only ever go from one to unknown, so each changes at most once after it is first known.
#include "compiler/verify/invariants/place_values.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "compiler/system/system.hpp"
#include "compiler/verify/net/abstract_code.hpp"

namespace bip::verify {

namespace {

// A chain of atoms that hand on values one after the other, against the order of the passes, is not worth more.
constexpr int kMaxPasses = 64;

using Values = std::vector<AbstractValue>;
/// What one connector writes before a port fires.
using Writes = std::vector<std::pair<u32, AbstractValue>>;

class PlaceValueAnalysis {
 public:
  PlaceValueAnalysis(const Net& net, const std::vector<std::uint8_t>& is_automaton)
      : net_(net),
        system_(*net.system),
        code_(system_.code),
        ways_(net.graph.port_count()),
        has_connector_(net.graph.port_count(), 0) {
    at_.resize(system_.atoms.size());
    for (u32 atom = 0; atom < system_.atoms.size(); ++atom) {
      stored_.push_back(stored_of(atom));
      if (is_automaton[atom] != 0 && is_simple(atom)) start(atom);
    }
    for (const Connector& connector : system_.connectors) {
      const bool writes = stores(connector);
      is_plain_.push_back(writes && has_plain_transfer(system_, connector) ? 1 : 0);
      for (const PortRef& ref : connector.ports) add_ways(ref, is_plain_.back() != 0, writes);
    }
  }

  PlaceValues run() {
    for (int pass = 0; is_changed_; ++pass) {
      if (pass == kMaxPasses) return {{}, std::vector<std::vector<std::uint8_t>>(system_.atoms.size())};
      is_changed_ = false;
      for (u32 c = 0; c < system_.connectors.size(); ++c) {
        if (is_plain_[c] != 0) transfer(system_.connectors[ConnectorId(std::size_t{c})], c);
      }
      for (u32 atom = 0; atom < system_.atoms.size(); ++atom) move(atom);
    }
    PlaceValues found;
    for (u32 atom = 0; atom < system_.atoms.size(); ++atom) {
      found.is_reached.emplace_back();
      for (u32 place = 0; place < at_[atom].size(); ++place) {
        const std::optional<Values>& values = at_[atom][place];
        found.is_reached.back().push_back(values ? 1 : 0);
        for (u32 variable = 0; values && variable < values->size(); ++variable) {
          if (stored_[atom][variable] != 0 && (*values)[variable].is_known)
            found.rows.push_back({atom, place, variable, (*values)[variable].value});
        }
      }
    }
    return found;
  }

 private:
  [[nodiscard]] const AtomType& type_of(u32 atom) const {
    return system_.atom_types[system_.atoms[AtomId(std::size_t{atom})].type];
  }
  [[nodiscard]] const analysis::DataAccess& access_of(u32 atom) const {
    return net_.access[net_.class_at(atom).type.value];
  }

  // Ints that change, and only by the atom's own actions.
  [[nodiscard]] std::vector<std::uint8_t> stored_of(u32 atom) const {
    const AtomType& type = type_of(atom);
    std::vector<std::uint8_t> stored(type.variables.size(), 0);
    for (const Transition& t : type.transitions) {
      for_each_assigned(code_, t.action, Op::LoadSelf, [&](u32 variable) { stored[variable] = 1; });
    }
    for (const std::vector<u32>& variables : access_of(atom).written) {
      for (u32 variable : variables) stored[variable] = 1;
    }
    for (u32 variable = 0; variable < stored.size(); ++variable) {
      if (type.variables[variable].type != Type::Int || type.variables[variable].is_param ||
          access_of(atom).unfollowed[variable] != 0)
        stored[variable] = 0;
    }
    return stored;
  }
  [[nodiscard]] bool is_simple(u32 atom) const {
    const AtomType& type = type_of(atom);
    return type.initial.size() == 1 &&
           std::find(stored_[atom].begin(), stored_[atom].end(), 1) != stored_[atom].end() &&
           std::all_of(type.transitions.begin(), type.transitions.end(),
                       [](const Transition& t) { return t.from.size() == 1 && t.to.size() == 1; });
  }
  // Only ints that are stored and what never changes are known.
  void forget(u32 atom, Values& values) const {
    const std::vector<AbstractValue> constants = constants_of(net_.class_at(atom));
    for (u32 variable = 0; variable < values.size(); ++variable) {
      if (stored_[atom][variable] == 0)
        values[variable] = variable < constants.size() ? constants[variable] : AbstractValue{};
    }
  }
  void start(u32 atom) {
    const AtomType& type = type_of(atom);
    Values values(type.variables.size(), known(0));
    forget(atom, values);
    execute(code_, type.initial_action, values);
    forget(atom, values);
    at_[atom].resize(type.places.size());
    at_[atom][type.initial[0]] = std::move(values);
  }

  [[nodiscard]] bool stores(const Connector& connector) const {
    const std::vector<Clause>& clauses = system_.connector_types[connector.type].clauses;
    return std::any_of(clauses.begin(), clauses.end(), [&](const Clause& clause) {
      return stores_into_ports(code_, clause.down) || stores_into_ports(code_, clause.up);
    });
  }
  // What a connector does to the ports that it takes, as far as that is known beforehand.
  void add_ways(const PortRef& ref, bool is_plain, bool writes) {
    if (ref.kind == PortRef::Kind::Choice) {
      for (const PortRef& port : system_.choices[ref.choice].ports) add_ways(port, is_plain, writes);
    } else if (ref.kind == PortRef::Kind::Atom) {
      const u32 port = net_.graph.port_base[ref.atom.value] + ref.port;
      has_connector_[port] = 1;
      if (is_plain) return;
      Writes unknown;
      for (u32 variable : access_of(ref.atom.value).written[ref.port]) {
        if (writes) unknown.emplace_back(variable, AbstractValue{});
      }
      add_way(port, std::move(unknown));
    }
  }
  void add_way(u32 port, Writes writes) {
    std::vector<Writes>& ways = ways_[port];
    if (std::find(ways.begin(), ways.end(), writes) != ways.end()) return;
    ways.push_back(std::move(writes));
    is_changed_ = true;
  }

  // What must be so where the condition holds; false: it never does.
  bool assume(ExprId condition, Values& values) const {
    if (!condition.is_valid()) return true;
    const Expr& e = code_.exprs[condition];
    if (e.op == Op::And) return assume(e.a, values) && assume(e.b, values);
    const AbstractValue whole = evaluate(code_, condition, values, {});
    if (whole.is_known) return whole.value != 0;
    if (e.op != Op::Eq || code_.exprs[e.a].type != Type::Int) return true;
    const AbstractValue a = evaluate(code_, e.a, values, {}), b = evaluate(code_, e.b, values, {});
    if (code_.exprs[e.a].op == Op::LoadSelf && b.is_known) values[code_.exprs[e.a].index] = b;
    if (code_.exprs[e.b].op == Op::LoadSelf && a.is_known) values[code_.exprs[e.b].index] = a;
    return true;
  }
  // False: no change.
  static bool join(std::optional<Values>& to, const Values& from) {
    if (!to) {
      to = from;
      return true;
    }
    bool is_changed = false;
    for (std::size_t k = 0; k < from.size(); ++k) {
      if (!(*to)[k].is_known || (*to)[k] == from[k]) continue;
      (*to)[k] = {};
      is_changed = true;
    }
    return is_changed;
  }
  // Where the port is enabled. Nothing: nowhere, so far.
  [[nodiscard]] std::optional<Values> values_at(u32 atom, u32 port) const {
    const AtomType& type = type_of(atom);
    std::optional<Values> result;
    if (at_[atom].empty()) {
      result.emplace(type.variables.size());
      forget(atom, *result);
      return result;
    }
    for (const Transition& t : type.transitions) {
      const std::optional<Values>& from = at_[atom][t.from[0]];
      if (t.port != port || !from) continue;
      Values values = *from;
      if (assume(t.guard, values)) join(result, values);
    }
    return result;
  }

  void transfer(const Connector& connector, u32 row) {
    const ConnectorType& type = system_.connector_types[connector.type];
    Values self(type.variables.size()), bind;
    std::vector<std::pair<u32, u32>> targets;  // by bind: port instance, variable
    for (std::size_t p = 0; p < type.params.size(); ++p) {
      const PortRef& ref = connector.ports[p];
      const std::optional<Values> values = values_at(ref.atom.value, ref.port);
      if (!values) return;
      const std::vector<u32>& variables = type_of(ref.atom.value).ports[ref.port].variables;
      bind.resize(type.params[p].first_bind + variables.size());
      targets.resize(bind.size(), {kNoRow, 0});
      for (std::size_t v = 0; v < variables.size(); ++v) {
        bind[type.params[p].first_bind + v] = (*values)[variables[v]];
        targets[type.params[p].first_bind + v] = {net_.graph.port_base[ref.atom.value] + ref.port, variables[v]};
      }
    }
    for (const DataRef& ref : connector.data) bind.push_back(constant_of(ref));
    std::set<u32> written;
    for_each_assigned(code_, type.clauses[0].down, Op::LoadBind, [&](u32 variable) {
      if (variable < targets.size()) written.insert(variable);
    });
    execute(code_, type.clauses[0].down, self, bind);
    for (std::size_t p = 0; p < type.params.size(); ++p) {
      const u32 port = net_.graph.port_base[connector.ports[p].atom.value] + connector.ports[p].port;
      Writes writes;
      for (u32 k : written) {
        if (targets[k].first == port) writes.emplace_back(targets[k].second, bind[k]);
      }
      set_way(port, row, std::move(writes));
    }
  }
  [[nodiscard]] AbstractValue constant_of(const DataRef& ref) const {
    const std::vector<AbstractValue> constants = constants_of(net_.class_at(ref.atom.value));
    return stored_[ref.atom.value][ref.variable] == 0 && ref.variable < constants.size() ? constants[ref.variable]
                                                                                         : AbstractValue{};
  }
  // What a plain connector writes goes from one value to unknown like everything else.
  void set_way(u32 port, u32 connector, Writes writes) {
    const auto [found, is_new] = plain_ways_.try_emplace({port, connector}, writes);
    if (!is_new && found->second == writes) return;
    found->second = std::move(writes);
    is_changed_ = true;
  }

  void move(u32 atom) {
    if (at_[atom].empty()) return;
    for (const Transition& t : type_of(atom).transitions) {
      if (!at_[atom][t.from[0]]) continue;
      Values before = *at_[atom][t.from[0]];
      if (!assume(t.guard, before)) continue;
      const auto go = [&](const Writes& writes) {
        Values values = before;
        for (const auto& [variable, value] : writes) values[variable] = value;
        execute(code_, t.action, values);
        forget(atom, values);
        is_changed_ = join(at_[atom][t.to[0]], values) || is_changed_;
      };
      const u32 port = t.port == Transition::kInternal ? kNoRow : net_.graph.port_base[atom] + t.port;
      if (port == kNoRow || has_connector_[port] == 0) {
        go({});
        continue;
      }
      for (const Writes& writes : ways_[port]) go(writes);
      for (auto way = plain_ways_.lower_bound({port, 0}); way != plain_ways_.end() && way->first.first == port; ++way)
        go(way->second);
    }
  }

  const Net& net_;
  const System& system_;
  const CodeTable& code_;
  std::vector<std::vector<std::uint8_t>> stored_;       // by atom, by variable
  std::vector<std::vector<std::optional<Values>>> at_;  // by atom, by place; empty: not looked at
  std::vector<std::vector<Writes>> ways_;               // by port instance: of connectors that are not followed
  std::map<std::pair<u32, u32>, Writes> plain_ways_;    // by port instance and connector
  std::vector<std::uint8_t> has_connector_, is_plain_;  // by port instance; by connector
  bool is_changed_ = true;
};

}  // namespace

PlaceValues find_place_values(const Net& net, const std::vector<std::uint8_t>& is_automaton) {
  return PlaceValueAnalysis(net, is_automaton).run();
}

bool stores_into_ports(const CodeTable& code, StmtId body) {
  bool found = false;
  for_each_assigned(code, body, Op::LoadBind, [&](u32) { found = true; });
  return found;
}

bool has_plain_transfer(const System& system, const Connector& connector) {
  const ConnectorType& type = system.connector_types[connector.type];
  if (std::none_of(type.clauses.begin(), type.clauses.end(),
                   [&](const Clause& clause) { return stores_into_ports(system.code, clause.down); }))
    return true;
  if (type.clauses.size() != 1 || type.clauses[0].params.size() != type.params.size() || type.clauses[0].up.is_valid())
    return false;
  if (std::any_of(type.define.begin(), type.define.end(), [](const DefineNode& node) { return node.trigger; }))
    return false;
  std::set<u32> atoms;
  for (const PortRef& ref : connector.ports) {
    if (ref.kind != PortRef::Kind::Atom || !atoms.insert(ref.atom.value).second) return false;
    const std::vector<u32>& variables = system.atom_types[system.atoms[ref.atom].type].ports[ref.port].variables;
    if (std::set<u32>(variables.begin(), variables.end()).size() != variables.size()) return false;
  }
  return true;
}

}  // namespace bip::verify
