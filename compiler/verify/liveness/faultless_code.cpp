// See faultless_code.hpp.
#include "compiler/verify/liveness/faultless_code.hpp"

#include <algorithm>
#include <span>
#include <string_view>

#include "compiler/model/code_uses.hpp"
#include "compiler/model/draws.hpp"
#include "compiler/model/operators.hpp"
#include "compiler/verify/invariants/interval_domain.hpp"
#include "runtime/core/graph_algorithms.hpp"

namespace bip::verify {

namespace {

class CodeChecker {
 public:
  // `whole`: between steps. `fixed`: at any time, as code may assign one value after the other.
  CodeChecker(const CodeTable& code, IntervalPoint whole, IntervalPoint fixed)
      : code_(code), domain_(code), whole_(std::move(whole)), fixed_(std::move(fixed)) {}

  // No call but draws of good arguments, and divisors that are neither 0 nor -1.
  [[nodiscard]] bool is_fine(ExprId root) {
    bool is = true;
    model::for_each_expr(code_, root, [&](const Expr& e) {
      if (e.op == Op::Call) is = is && is_fine_draw(e);
      if (!is_division(e.op) || e.type != Type::Int) return;
      IntervalPoint point = fixed_;
      const Range by = domain_.evaluate(e.b, point);
      is = is && (by.low > 0 || by.high < -1);
    });
    return is;
  }
  [[nodiscard]] bool is_fine(StmtId body) {
    bool is = true;
    model::for_each_stmt(code_, body, [&](const Stmt& s) { is = is && is_fine(s.value); });
    return is;
  }
  [[nodiscard]] bool exclude_each_other(ExprId a, ExprId b) {
    IntervalPoint point = whole_;
    return !(assume(a, point) && assume(b, point) && assume(a, point));
  }

 private:
  bool is_fine_draw(const Expr& call) {
    const rt::ProbabilityDistribution* distribution = model::distribution_of(code_.functions[call.index]);
    if (distribution == nullptr) return false;
    if (model::has_good_constants(code_, call)) return true;
    const std::span<const ExprId> args = code_.args_of(call).subspan(1);
    if (distribution->name != std::string_view("uniform") || code_.exprs[args[0]].type != Type::Int) return false;
    IntervalPoint point = fixed_;
    const Range low = domain_.evaluate(args[0], point), high = domain_.evaluate(args[1], point);
    return !low.is_empty() && !high.is_empty() && low.high <= high.low;
  }
  bool assume(ExprId guard, IntervalPoint& point) { return !guard.is_valid() || domain_.assume(guard, true, point); }

  const CodeTable& code_;
  IntervalDomain domain_;
  IntervalPoint whole_, fixed_;
};

// Do internal transitions lead from no place back to it?
bool ends_internals(const AtomType& type) {
  std::vector<std::vector<u32>> next(type.places.size());
  for (const Transition& t : type.transitions) {
    if (t.port == Transition::kInternal) next[t.from.front()].push_back(t.to.front());
  }
  const auto cycle = find_cycle(
      static_cast<u32>(next.size()), [](u32) { return std::size_t{0}; },
      [&](u32 place, std::size_t& at) { return at < next[place].size() ? next[place][at++] : kNoSuccessor; },
      [](u32, u32) { return true; });
  return cycle.empty();
}

bool is_faultless_atom(const RegionNet& net, u32 atom) {
  const AtomType& type = net.type_of(atom);
  if (!type.is_automaton() || !type.invariants.empty() || !type.priorities.empty() || !ends_internals(type))
    return false;
  IntervalPoint whole, fixed;
  for (u32 k = 0; k < type.variables.size(); ++k) {
    whole.self.push_back(net.range(atom, k));
    fixed.self.push_back(type.variables[k].is_param ? net.range(atom, k) : kAnyInt);
  }
  CodeChecker code(net.system->code, std::move(whole), std::move(fixed));
  // What the first values are drawn from decides whether there is a fault.
  if (type.draws != AtomType::kNoDraws && !code.is_fine(type.initial_action)) return false;
  for (std::size_t row = 0; row < type.transitions.size(); ++row) {
    const Transition& t = type.transitions[row];
    if (!code.is_fine(t.guard) || !code.is_fine(t.action)) return false;
    const bool is_sole = std::all_of(
        type.transitions.begin(), type.transitions.begin() + static_cast<std::ptrdiff_t>(row),
        [&](const Transition& other) {
          return other.port != t.port || other.from != t.from || code.exclude_each_other(other.guard, t.guard);
        });
    if (!is_sole) return false;
  }
  return true;
}

bool is_faultless_connector(const RegionNet& net, u32 row) {
  const ConnectorType& type = net.type_of(net.connector(row));
  CodeChecker code(net.system->code, {}, {});
  return std::all_of(type.clauses.begin(), type.clauses.end(), [&](const Clause& clause) {
    return code.is_fine(clause.guard) && code.is_fine(clause.up) && code.is_fine(clause.down);
  });
}

}  // namespace

bool FaultlessCode::has_all() const {
  return std::find(is_atom.begin(), is_atom.end(), 0) == is_atom.end() &&
         std::find(is_connector.begin(), is_connector.end(), 0) == is_connector.end();
}

FaultlessCode find_faultless_code(const RegionNet& net) {
  const System& system = *net.system;
  FaultlessCode result{std::vector<std::uint8_t>(system.atoms.size(), 0),
                       std::vector<std::uint8_t>(system.connectors.size(), 0)};
  if (!system.priorities.empty()) return result;
  for (u32 atom = 0; atom < system.atoms.size(); ++atom) result.is_atom[atom] = is_faultless_atom(net, atom) ? 1 : 0;
  for (u32 row = 0; row < system.connectors.size(); ++row)
    result.is_connector[row] = is_faultless_connector(net, row) ? 1 : 0;
  return result;
}

}  // namespace bip::verify
