// See port_uses.hpp.
#include "compiler/verify/net/port_uses.hpp"

#include <algorithm>
#include <set>

#include "compiler/model/code_uses.hpp"
#include "compiler/system/system.hpp"
#include "compiler/verify/net/net.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

class PortUseAnalysis {
 public:
  explicit PortUseAnalysis(const Net& net) : net_(net), system_(*net.system) {
    for (const ModeClass& row : net.classes) constants_.push_back(constants_of(row));
  }

  PortUses run() {
    PortUses all;
    all.of_atom.resize(system_.atoms.size());
    all.of_param.resize(system_.connectors.size());
    // First every use, then their rows once they are sorted.
    std::vector<std::vector<PortUse>> told(system_.atoms.size());
    std::vector<std::pair<std::uint32_t, std::vector<PortUse>>> by_connector;
    for (std::size_t c = 0; c < system_.connectors.size(); ++c) {
      const Connector& connector = system_.connectors[ConnectorId(c)];
      std::vector<PortUse> uses = uses_of(connector);
      bool is_told = false;
      for (std::size_t p = 0; p < uses.size(); ++p) {
        if (!is_worth_it(uses[p])) continue;
        told[connector.ports[p].atom.value].push_back(uses[p]);
        is_told = true;
      }
      if (is_told) by_connector.emplace_back(static_cast<std::uint32_t>(c), std::move(uses));
    }
    for (std::size_t a = 0; a < told.size(); ++a) {
      if (told[a].empty()) continue;
      std::sort(told[a].begin(), told[a].end());
      told[a].erase(std::unique(told[a].begin(), told[a].end()), told[a].end());
      all.of_atom[a].uses = std::move(told[a]);
      all.of_atom[a].is_plain.assign(net_.class_at(static_cast<u32>(a)).moves.size(), 0);
      all.has_some = true;
    }
    for (const auto& [c, uses] : by_connector) {
      const Connector& connector = system_.connectors[ConnectorId(std::size_t{c})];
      for (std::size_t p = 0; p < uses.size(); ++p) {
        all.of_param[c].push_back(0);
        if (!is_worth_it(uses[p])) continue;
        const std::vector<PortUse>& known = all.of_atom[connector.ports[p].atom.value].uses;
        const auto place = std::lower_bound(known.begin(), known.end(), uses[p]);
        BIP_ASSERT(place != known.end() && *place == uses[p], "a use of connector {} is none of its atom", c);
        all.of_param[c].back() = static_cast<std::uint32_t>(place - known.begin()) + 1;
      }
    }
    mark_plain(all);
    return all;
  }

 private:
  static bool is_worth_it(const PortUse& use) {
    return use.guard.is_valid() ||
           std::any_of(use.writes.begin(), use.writes.end(), [](const auto& w) { return w.second.is_known; });
  }
  [[nodiscard]] bool is_looked_at(const Connector& connector, const ConnectorType& type) const {
    if (type.exports || type.clauses.size() != 1 || type.clauses[0].params.size() != type.params.size() ||
        type.clauses[0].up.is_valid())
      return false;
    if (is_always_true(system_.code, type.clauses[0].guard) && !type.clauses[0].down.is_valid()) return false;
    for (const DefineNode& node : type.define) {
      if (node.trigger) return false;
    }
    std::set<std::uint32_t> atoms;
    for (const PortRef& ref : connector.ports) {
      if (ref.kind != PortRef::Kind::Atom || !atoms.insert(ref.atom.value).second) return false;
      const std::vector<std::uint32_t>& variables = variables_of(ref);
      if (std::set<std::uint32_t>(variables.begin(), variables.end()).size() != variables.size()) return false;
    }
    return true;
  }
  [[nodiscard]] const std::vector<std::uint32_t>& variables_of(const PortRef& ref) const {
    return system_.atom_types[system_.atoms[ref.atom].type].ports[ref.port].variables;
  }

  // The transfer, over values that may be unknown.
  void execute_transfer(StmtId body, std::vector<AbstractValue>& bind, std::vector<std::uint8_t>& is_stored) const {
    for (StmtId id = body; id.is_valid(); id = system_.code.stmts[id].next) {
      const Stmt& s = system_.code.stmts[id];
      // Only the ports' variables are followed.
      if (model::assigned_variable(s, Op::LoadBind)) store(s, bind, is_stored);
      else if (model::is_choice(s)) branch(s, bind, is_stored);
    }
  }
  void store(const Stmt& s, std::vector<AbstractValue>& bind, std::vector<std::uint8_t>& is_stored) const {
    if (s.index >= bind.size()) return;
    const bool is_exact = s.type == Type::Int || s.type == Type::Bool || s.type == Type::String;
    BIP_ASSERT(is_stored.size() == bind.size(), "{} marks of {} data", is_stored.size(), bind.size());
    bind[s.index] = is_exact ? evaluate(system_.code, s.value, {}, bind) : AbstractValue{};
    is_stored[s.index] = 1;
  }
  void branch(const Stmt& s, std::vector<AbstractValue>& bind, std::vector<std::uint8_t>& is_stored) const {
    const AbstractValue condition = evaluate(system_.code, s.value, {}, bind);
    if (condition.is_known) return execute_transfer(condition.value != 0 ? s.then_body : s.else_body, bind, is_stored);
    std::vector<AbstractValue> other = bind;
    execute_transfer(s.then_body, bind, is_stored);
    execute_transfer(s.else_body, other, is_stored);
    for (std::size_t k = 0; k < bind.size(); ++k) {
      if (bind[k] != other[k]) bind[k] = {};
    }
  }

  // One a parameter; none of a connector that is not looked at.
  std::vector<PortUse> uses_of(const Connector& connector) const {
    const ConnectorType& type = system_.connector_types[connector.type];
    if (!is_looked_at(connector, type)) return {};
    const Clause& clause = type.clauses[0];
    std::vector<AbstractValue> before(type.bind_count(system_.port_types));
    for (std::size_t p = 0; p < type.params.size(); ++p) {
      const PortRef& ref = connector.ports[p];
      const std::vector<AbstractValue>& constants = constants_[net_.class_of[ref.atom.value]];
      const std::vector<std::uint32_t>& variables = variables_of(ref);
      for (std::size_t v = 0; v < variables.size() && variables[v] < constants.size(); ++v)
        before[type.params[p].first_bind + v] = constants[variables[v]];
    }
    std::vector<AbstractValue> after = before;
    std::vector<std::uint8_t> is_stored(before.size(), 0);
    execute_transfer(clause.down, after, is_stored);
    std::vector<PortUse> uses;
    for (std::size_t p = 0; p < type.params.size(); ++p) {
      const PortRef& ref = connector.ports[p];
      const ModeClass& row = net_.class_at(ref.atom.value);
      const std::vector<std::uint32_t>& variables = variables_of(ref);
      const std::uint32_t first = type.params[p].first_bind;
      PortUse use{ref.port, {}, {}, {}};
      for (std::size_t v = 0; v < variables.size(); ++v) {
        if (row.followed[variables[v]] != 0 && is_stored[first + v] != 0)
          use.writes.emplace_back(variables[v], after[first + v]);
      }
      std::sort(use.writes.begin(), use.writes.end());
      add_guard(clause.guard, before, first, variables, row, use);
      uses.push_back(std::move(use));
    }
    return uses;
  }

  // A guard that only the atom decides: everything else in it never changes.
  void add_guard(ExprId guard, const std::vector<AbstractValue>& before, std::uint32_t first,
                 const std::vector<std::uint32_t>& variables, const ModeClass& row, PortUse& use) const {
    bool reads_own = false, others_are_known = true;
    std::vector<UseSource> bind(before.size());
    for_each_expr(system_.code, guard, [&](const Expr& e) {
      if (e.op == Op::Call || e.op == Op::LoadSelf) others_are_known = false;
      if (e.op != Op::LoadBind) return;
      const bool is_own = e.index >= first && e.index - first < variables.size();
      if (is_own && row.followed[variables[e.index - first]] != 0 && !before[e.index].is_known) {
        reads_own = true;
        bind[e.index] = {variables[e.index - first], {}};
      } else if (e.index < before.size() && before[e.index].is_known) {
        bind[e.index].value = before[e.index];
      } else {
        others_are_known = false;
      }
    });
    if (!reads_own || !others_are_known) return;
    use.guard = guard;
    use.bind = std::move(bind);
  }

  void plain(PortUses& all, const PortRef& ref) const {
    if (ref.kind == PortRef::Kind::Choice) {
      for (const PortRef& port : system_.choices[ref.choice].ports) plain(all, port);
    } else if (ref.kind == PortRef::Kind::Atom && !all.of_atom[ref.atom.value].is_plain.empty()) {
      all.of_atom[ref.atom.value].is_plain[ref.port] = 1;
    }
  }
  void mark_plain(PortUses& all) const {
    for (std::size_t c = 0; c < system_.connectors.size(); ++c) {
      const Connector& connector = system_.connectors[ConnectorId(c)];
      for (std::size_t p = 0; p < connector.ports.size(); ++p) {
        if (all.of_param[c].empty() || all.of_param[c][p] == 0) plain(all, connector.ports[p]);
      }
    }
    for (std::size_t a = 0; a < all.of_atom.size(); ++a) {
      AtomUses& uses = all.of_atom[a];
      const AtomType& type = system_.atom_types[system_.atoms[AtomId(a)].type];
      for (std::size_t port = 0; port < uses.is_plain.size(); ++port) {
        if (!type.ports[port].exported) uses.is_plain[port] = 1;
      }
    }
  }

  const Net& net_;
  const System& system_;
  std::vector<std::vector<AbstractValue>> constants_;  // by class, by variable
};

}  // namespace

PortUses find_port_uses(const Net& net) { return PortUseAnalysis(net).run(); }

}  // namespace bip::verify
