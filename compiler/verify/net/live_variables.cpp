// See live_variables.hpp. What an action reads counts as read even if it is only stored elsewhere.
#include "compiler/verify/net/live_variables.hpp"

#include <algorithm>

#include "compiler/system/system.hpp"

namespace bip::verify {

std::vector<std::vector<std::uint8_t>> find_live_variables(const System& system, AtomTypeId id,
                                                           const analysis::DataAccess& access, const AtomUses& uses) {
  const AtomType& type = system.atom_types[id];
  const CodeTable& code = system.code;
  if (!type.is_automaton()) return {};
  const std::size_t variables = type.variables.size();
  const auto mark = [&](ExprId expr, std::vector<std::uint8_t>& read) {
    for_each_expr(code, expr, [&](const Expr& e) {
      if (e.op == Op::LoadSelf) read[e.index] = 1;
    });
  };
  std::vector<std::uint8_t> everywhere = access.read_anywhere;
  for (const AtomPriority& rule : type.priorities) mark(rule.guard, everywhere);
  for (const Invariant& invariant : type.invariants) mark(invariant.condition, everywhere);
  struct Flow {
    std::uint32_t from = 0, to = 0;
    std::vector<std::uint8_t> reads, keeps;  // by variable
  };
  std::vector<Flow> flows;
  for (const Transition& t : type.transitions) {
    Flow flow{t.from[0], t.to[0], std::vector<std::uint8_t>(variables, 0), std::vector<std::uint8_t>(variables, 1)};
    if (t.port != Transition::kInternal) {
      // All uses of the port write it.
      for (std::size_t k = 0; k < variables; ++k) {
        bool has_use = false, is_written = !uses.is_plain.empty() && uses.is_plain[t.port] == 0;
        for (const PortUse& use : uses.uses) {
          if (use.port != t.port) continue;
          has_use = true;
          is_written = is_written &&
                       std::any_of(use.writes.begin(), use.writes.end(), [&](const auto& w) { return w.first == k; });
        }
        if (has_use && is_written) flow.keeps[k] = 0;
      }
    }
    std::vector<std::uint8_t> in_action(variables, 0);
    for_each_stmt(code, t.action, [&](const Stmt& s) { mark(s.value, in_action); });
    for (std::size_t k = 0; k < variables; ++k) flow.reads[k] = in_action[k] != 0 && flow.keeps[k] != 0 ? 1 : 0;
    for (StmtId s = t.action; s.is_valid(); s = code.stmts[s].next) {
      if (code.stmts[s].op == StmtOp::StoreSelf) flow.keeps[code.stmts[s].index] = 0;
    }
    mark(t.guard, flow.reads);
    if (t.port != Transition::kInternal) {
      for (std::uint32_t variable : access.read[t.port]) flow.reads[variable] = 1;
    }
    flows.push_back(std::move(flow));
  }
  std::vector<std::vector<std::uint8_t>> live(type.places.size(), everywhere);
  for (bool changed = true; changed;) {
    changed = false;
    for (const Flow& flow : flows) {
      for (std::size_t k = 0; k < variables; ++k) {
        const bool is_live = flow.reads[k] != 0 || (flow.keeps[k] != 0 && live[flow.to][k] != 0);
        if (!is_live || live[flow.from][k] != 0) continue;
        live[flow.from][k] = 1;
        changed = true;
      }
    }
  }
  return live;
}

}  // namespace bip::verify
