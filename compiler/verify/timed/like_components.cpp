// See like_components.hpp.
#include "compiler/verify/timed/like_components.hpp"

#include <algorithm>
#include <functional>
#include <tuple>

#include "compiler/model/code_uses.hpp"
#include "compiler/verify/scaling/index_families.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// What a value is: not a number, one of a component of the array, one of an atom outside or a constant.
enum class NumberUse : std::uint8_t { None, OfComponent, Outside };

class LikenessCheck {
 public:
  LikenessCheck(const System& system, const Neighbours& neighbours, u32 atom, std::string& reason)
      : system_(system), neighbours_(neighbours), reason_(reason), atom_(atom) {}

  std::optional<LikeComponents> run() {
    if (!find_array() || !connectors_are_alike() || !find_numbers()) return std::nullopt;
    if (!like_.numbers.empty() && !numbers_are_only_compared()) return std::nullopt;
    return std::move(like_);
  }

 private:
  bool fail(const std::string& reason) {
    reason_ = reason;
    return false;
  }
  [[nodiscard]] const Atom& row_of(u32 atom) const { return system_.atoms[AtomId(std::size_t{atom})]; }
  [[nodiscard]] const AtomType& type_of(u32 atom) const { return system_.atom_types[row_of(atom).type]; }
  [[nodiscard]] bool is_like(u32 atom) const {
    return std::binary_search(like_.atoms.begin(), like_.atoms.end(), atom);
  }

  bool find_array() {
    const std::optional<IndexFamilies> families = find_families(system_);
    if (!families) return fail("an array has gaps");
    like_.atoms = families->rows[families->of_atom[atom_].family].atoms;
    if (like_.atoms.size() < 3) return fail("there are no three components that are alike");
    for (u32 atom = 0; atom < system_.atoms.size(); ++atom) {
      if (!is_like(atom)) like_.outside.push_back(atom);
    }
    BIP_ASSERT(is_like(atom_) && like_.atoms.size() + like_.outside.size() == system_.atoms.size(),
               "{} components are alike and {} are outside, of {}", like_.atoms.size(), like_.outside.size(),
               system_.atoms.size());
    if (!type_of(atom_).is_automaton()) return fail("`" + type_of(atom_).name + "` may be at several places at once");
    return true;
  }

  // By component: its connectors' types, its ports, and the ports of atoms outside, parameter by parameter.
  bool connectors_are_alike() {
    using Use = std::tuple<u32, u32, std::vector<std::pair<u32, u32>>>;  // type, connector if all are in it, ports
    std::vector<std::vector<Use>> uses(like_.atoms.size());
    for (u32 row = 0; row < neighbours_.tops().size(); ++row) {
      const Neighbours::Top& top = neighbours_.tops()[row];
      std::vector<u32> mine;
      for (u32 atom : top.atoms) {
        if (is_like(atom)) mine.push_back(atom);
      }
      if (mine.empty()) continue;
      const Connector& connector = system_.connectors[top.connector];
      const ConnectorType& type = system_.connector_types[connector.type];
      const bool has_all = mine.size() == like_.atoms.size(), is_free = type.clauses.empty() && connector.data.empty();
      if (!top.is_plain || top.is_sync || !connector.data.empty() || (mine.size() > 1 && !(has_all && is_free)))
        return fail("`" + connector.path + "` does not treat all alike");
      for (u32 atom : mine) {
        Use use{connector.type.value, has_all && mine.size() > 1 ? row : kNoRow, {}};
        u32 port_here = kNoRow;
        for (const PortRef& ref : connector.ports) {
          if (ref.atom.value == atom) port_here = ref.port;
          if (ref.atom.value == atom) std::get<2>(use).emplace_back(kNoRow, ref.port);
          else if (!is_like(ref.atom.value)) std::get<2>(use).emplace_back(ref.atom.value, ref.port);
        }
        if (port_here == kNoRow) return fail("`" + connector.path + "` reads data of who takes no part");
        if (mine.size() > 1) std::sort(std::get<2>(use).begin(), std::get<2>(use).end());
        uses[static_cast<std::size_t>(std::lower_bound(like_.atoms.begin(), like_.atoms.end(), atom) -
                                      like_.atoms.begin())]
            .push_back(std::move(use));
      }
    }
    for (std::vector<Use>& row : uses) std::sort(row.begin(), row.end());
    if (std::any_of(uses.begin(), uses.end(), [&](const std::vector<Use>& row) { return row != uses.front(); }))
      return fail("the connectors of the array's components differ");
    return true;
  }

  // Parameters that differ must be ints, different for each two components.
  bool find_numbers() {
    const Atom& first = row_of(like_.atoms.front());
    const AtomType& type = type_of(like_.atoms.front());
    like_.is_number.assign(type.variables.size(), 0);
    std::vector<u32> params;
    for (u32 variable = 0; variable < type.variables.size(); ++variable) {
      if (type.variables[variable].is_param) params.push_back(variable);
    }
    if (params.size() != first.args.size()) return fail("parameters of `" + type.name + "` are hidden");
    for (std::size_t k = 0; k < params.size(); ++k) {
      std::vector<std::int32_t> values;
      bool differ = false;
      for (u32 atom : like_.atoms) {
        const Value& value = row_of(atom).args[k];
        differ = differ || value != first.args[k];
        values.push_back(value.int_value);
      }
      if (!differ) continue;
      std::vector<std::int32_t> distinct = values;
      std::sort(distinct.begin(), distinct.end());
      const bool are_distinct = std::adjacent_find(distinct.begin(), distinct.end()) == distinct.end();
      if (type.variables[params[k]].type != Type::Int || !are_distinct ||
          (!like_.numbers.empty() && values != like_.numbers))
        return fail("parameter `" + type.variables[params[k]].name + "` is no number");
      like_.numbers = std::move(values);
      like_.is_number[params[k]] = 1;
    }
    // Data that are given such a parameter at first, and nothing else ever.
    std::vector<std::uint32_t> stores(type.variables.size(), 0);
    std::vector<std::pair<u32, u32>> copies;
    const auto count = [&](StmtId body) {
      model::for_each_assigned(system_.code, body, Op::LoadSelf, [&](u32 variable) { ++stores[variable]; });
    };
    count(type.initial_action);
    for (const Transition& t : type.transitions) count(t.action);
    model::for_each_stmt(system_.code, type.initial_action, [&](const Stmt& s) {
      const std::optional<u32> copy = model::assigned_variable(s, Op::LoadSelf);
      const Expr& value = system_.code.exprs[s.value];
      if (copy && value.op == Op::LoadSelf && like_.is_number[value.index] != 0)
        copies.emplace_back(*copy, value.index);
    });
    for (const Neighbours::Top& top : neighbours_.tops()) {
      for (const auto& [atom, variable] : top.written) {
        if (is_like(atom)) stores[variable] += 2;
      }
    }
    for (const auto& [copy, from] : copies) {
      if (stores[copy] == 1) like_.is_number[copy] = 1;
    }
    return true;
  }

  // No code of the components reads a number, but to copy it; connectors compare them and hand them out; atoms outside
  // compare them with constants that are none.
  bool numbers_are_only_compared() {
    BIP_ASSERT(like_.numbers.size() == like_.atoms.size(), "{} numbers of {} components", like_.numbers.size(),
               like_.atoms.size());
    const AtomType& type = type_of(like_.atoms.front());
    const auto of_component = [&](const Expr& e) {
      return e.op == Op::LoadSelf && like_.is_number[e.index] != 0 ? NumberUse::OfComponent : NumberUse::None;
    };
    bool is_copied_only = true;
    model::for_each_stmt(system_.code, type.initial_action, [&](const Stmt& s) {
      const std::optional<u32> stored = model::assigned_variable(s, Op::LoadSelf);
      const bool is_copy = stored && like_.is_number[*stored] != 0;
      if (!is_copy && !is_free_of_numbers(s.value, of_component)) is_copied_only = false;
    });
    if (!is_copied_only || !type_is_free_of_numbers(type, of_component))
      return fail("code of `" + type.name + "` reads numbers");
    // Which variables outside hold numbers: those that connectors write them to.
    for (const Neighbours::Top& top : neighbours_.tops()) {
      if (!transfers_are_fine(top))
        return fail("`" + system_.connectors[top.connector].path + "` computes with numbers");
    }
    for (const Neighbours::Top& top : neighbours_.tops()) {
      if (!guards_are_fine(top)) return fail("`" + system_.connectors[top.connector].path + "` computes with numbers");
    }
    for (u32 atom : like_.outside) {
      if (!outside_is_fine(atom)) return fail("`" + row_of(atom).path + "` computes with numbers");
    }
    return true;
  }

  using Classify = std::function<NumberUse(const Expr&)>;
  [[nodiscard]] bool is_constant_beside(ExprId id) const {
    const Expr& e = system_.code.exprs[id];
    return e.op == Op::ConstInt &&
           std::find(like_.numbers.begin(), like_.numbers.end(), e.int_value) == like_.numbers.end();
  }
  // Numbers are only compared: with each other, unless both are outside, and with constants that are none.
  [[nodiscard]] bool is_fine(ExprId id, const Classify& use_of) const {
    if (!id.is_valid()) return true;
    const Expr& e = system_.code.exprs[id];
    if (use_of(e) != NumberUse::None) return false;
    if (e.op == Op::Call) return is_free_of_numbers(id, use_of);
    if (e.op != Op::Eq && e.op != Op::Ne) return is_fine(e.a, use_of) && is_fine(e.b, use_of);
    const NumberUse a = use_of(system_.code.exprs[e.a]), b = use_of(system_.code.exprs[e.b]);
    if (a == NumberUse::None && b == NumberUse::None) return is_fine(e.a, use_of) && is_fine(e.b, use_of);
    if (a == NumberUse::None) return is_constant_beside(e.a);
    if (b == NumberUse::None) return is_constant_beside(e.b);
    return a != b;
  }
  [[nodiscard]] bool is_free_of_numbers(ExprId id, const Classify& use_of) const {
    bool is_free = true;
    model::for_each_expr(system_.code, id, [&](const Expr& e) { is_free = is_free && use_of(e) == NumberUse::None; });
    return is_free;
  }
  [[nodiscard]] bool body_is_free_of_numbers(StmtId body, const Classify& use_of) const {
    bool is_free = true;
    model::for_each_stmt(system_.code, body,
                         [&](const Stmt& s) { is_free = is_free && is_free_of_numbers(s.value, use_of); });
    return is_free;
  }
  [[nodiscard]] bool type_is_free_of_numbers(const AtomType& type, const Classify& use_of) const {
    const auto time_is_free = [&](const TimeGuard& when) { return body_is_free_of_numbers(when.measure, use_of); };
    for (const Transition& t : type.transitions) {
      if (!is_free_of_numbers(t.guard, use_of) || !body_is_free_of_numbers(t.action, use_of) || !time_is_free(t.when) ||
          !is_free_of_numbers(t.resume.guard, use_of) || !time_is_free(t.resume.when) ||
          t.weight.param != Weight::kNone)
        return false;
    }
    for (const Invariant& invariant : type.invariants) {
      if (!is_free_of_numbers(invariant.condition, use_of) || !time_is_free(invariant.when)) return false;
    }
    return std::all_of(type.priorities.begin(), type.priorities.end(),
                       [&](const AtomPriority& rule) { return is_free_of_numbers(rule.guard, use_of); });
  }

  // The variable that a connector calls Bind k; kNoRow: none of an atom's port.
  [[nodiscard]] std::pair<u32, u32> variable_of(const Connector& connector, u32 bind) const {
    const ConnectorType& type = system_.connector_types[connector.type];
    for (std::size_t p = type.params.size(); p-- > 0;) {
      if (bind < type.params[p].first_bind) continue;
      const PortRef& ref = connector.ports[p];
      if (ref.kind != PortRef::Kind::Atom) break;
      const std::vector<u32>& variables = type_of(ref.atom.value).ports[ref.port].variables;
      const u32 row = bind - type.params[p].first_bind;
      if (row < variables.size()) return {ref.atom.value, variables[row]};
      break;
    }
    return {kNoRow, 0};
  }
  // The variable that a transfer's statement assigns; kNoRow: none of an atom's port.
  [[nodiscard]] std::pair<u32, u32> target_of(const Connector& connector, const Stmt& s) const {
    const std::optional<u32> bind = model::assigned_variable(s, Op::LoadBind);
    return bind ? variable_of(connector, *bind) : std::pair<u32, u32>{kNoRow, 0};
  }
  [[nodiscard]] Classify use_in(const Connector& connector) const {
    return [this, &connector](const Expr& e) {
      if (e.op != Op::LoadBind) return NumberUse::None;
      const std::pair<u32, u32> variable = variable_of(connector, e.index);
      if (variable.first == kNoRow) return NumberUse::None;
      if (is_like(variable.first))
        return like_.is_number[variable.second] != 0 ? NumberUse::OfComponent : NumberUse::None;
      return like_.number_outside.contains(variable) ? NumberUse::Outside : NumberUse::None;
    };
  }
  // A transfer hands a number to an atom outside, as it is.
  bool transfers_are_fine(const Neighbours::Top& top) {
    bool is_fine_so_far = true;
    for (u32 row : top.tree) {
      const Connector& connector = system_.connectors[ConnectorId(std::size_t{row})];
      const ConnectorType& type = system_.connector_types[connector.type];
      const Classify use_of = use_in(connector);
      for (const Clause& clause : type.clauses) {
        if (!body_is_free_of_numbers(clause.up, use_of)) return false;
        model::for_each_stmt(system_.code, clause.down, [&](const Stmt& s) {
          const bool is_number = s.value.is_valid() && use_of(system_.code.exprs[s.value]) == NumberUse::OfComponent;
          const std::pair<u32, u32> to = target_of(connector, s);
          if (is_number && to.first != kNoRow && !is_like(to.first)) like_.number_outside.insert(to);
          else if (!is_free_of_numbers(s.value, use_of)) is_fine_so_far = false;
        });
      }
    }
    return is_fine_so_far;
  }
  // Once it is known what holds numbers.
  [[nodiscard]] bool guards_are_fine(const Neighbours::Top& top) const {
    for (u32 row : top.tree) {
      const Connector& connector = system_.connectors[ConnectorId(std::size_t{row})];
      const ConnectorType& type = system_.connector_types[connector.type];
      const Classify use_of = use_in(connector);
      for (const Clause& clause : type.clauses) {
        if (!is_fine(clause.guard, use_of) || !body_is_free_of_numbers(clause.up, use_of)) return false;
        bool is_fine_so_far = true;
        model::for_each_stmt(system_.code, clause.down, [&](const Stmt& s) {
          const bool is_valid = s.value.is_valid();
          const std::pair<u32, u32> to = target_of(connector, s);
          const bool holds_number = to.first != kNoRow && like_.number_outside.contains(to);
          const bool is_number = is_valid && use_of(system_.code.exprs[s.value]) == NumberUse::OfComponent;
          if (holds_number ? !is_number && !is_constant_beside(s.value)
                           : is_valid && !is_free_of_numbers(s.value, use_of))
            is_fine_so_far = false;
        });
        if (!is_fine_so_far) return false;
      }
      for (const DataRef& data : connector.data) {
        if (like_.number_outside.contains({data.atom.value, data.variable})) return false;
      }
    }
    return true;
  }
  [[nodiscard]] bool outside_is_fine(u32 atom) const {
    const AtomType& type = type_of(atom);
    const Classify use_of = [&](const Expr& e) {
      return e.op == Op::LoadSelf && like_.number_outside.contains({atom, e.index}) ? NumberUse::Outside
                                                                                    : NumberUse::None;
    };
    bool is_fine_so_far = true;
    const auto see_body = [&](StmtId body) {
      model::for_each_stmt(system_.code, body, [&](const Stmt& s) {
        const std::optional<u32> stored = model::assigned_variable(s, Op::LoadSelf);
        const bool is_kept = stored && like_.number_outside.contains({atom, *stored});
        if (is_kept ? !is_constant_beside(s.value) : !is_fine(s.value, use_of)) is_fine_so_far = false;
      });
    };
    const auto see_guard = [&](ExprId guard) { is_fine_so_far = is_fine_so_far && is_fine(guard, use_of); };
    see_body(type.initial_action);
    for (const Transition& t : type.transitions) {
      see_guard(t.guard);
      see_body(t.action);
      see_guard(t.resume.guard);
      is_fine_so_far = is_fine_so_far && body_is_free_of_numbers(t.when.measure, use_of) &&
                       body_is_free_of_numbers(t.resume.when.measure, use_of);
    }
    for (const Invariant& invariant : type.invariants) {
      see_guard(invariant.condition);
      is_fine_so_far = is_fine_so_far && body_is_free_of_numbers(invariant.when.measure, use_of);
    }
    for (const AtomPriority& rule : type.priorities) see_guard(rule.guard);
    // Parameters that hold no number, but might by accident be equal to one.
    for (const auto& [owner, variable] : like_.number_outside) {
      if (owner == atom && type.variables[variable].is_param) is_fine_so_far = false;
    }
    return is_fine_so_far;
  }

  const System& system_;
  const Neighbours& neighbours_;
  std::string& reason_;
  u32 atom_;
  LikeComponents like_;
};

}  // namespace

std::optional<LikeComponents> find_like_components(const System& system, const Neighbours& neighbours, u32 atom,
                                                   std::string& reason) {
  return LikenessCheck(system, neighbours, atom, reason).run();
}

std::vector<OutsideStep> outside_steps(const LikeComponents& like, const Neighbours& neighbours, u32 atom) {
  std::vector<OutsideStep> steps;
  BIP_ASSERT(std::binary_search(like.atoms.begin(), like.atoms.end(), atom), "atom {} is outside", atom);
  for (u32 row : neighbours.tops_of(atom)) {
    const Neighbours::Top& top = neighbours.tops()[row];
    OutsideStep step{.leaves = {}, .port = kNoRow, .top = row};
    bool has_like = false;
    for (const Neighbours::Leaf& leaf : top.leaves) {
      if (leaf.atom == atom) step.port = leaf.port;
      else if (std::binary_search(like.atoms.begin(), like.atoms.end(), leaf.atom)) has_like = true;
      else step.leaves.push_back(leaf);
    }
    if (step.port != kNoRow && !has_like && !step.leaves.empty()) steps.push_back(std::move(step));
  }
  return steps;
}

}  // namespace bip::verify
