// See unread_cpp.hpp.
#include "compiler/verify/net/unread_cpp.hpp"

#include <algorithm>

#include "compiler/model/code_uses.hpp"
#include "compiler/model/operators.hpp"
#include "compiler/system/system.hpp"
#include "compiler/verify/net/unread_data.hpp"

namespace bip::verify {

namespace {

// What an expression does beside having a value.
struct CallUse {
  bool calls = false;
  bool is_droppable = true;  // nothing is given by reference, and nothing divides
};
CallUse call_use(const CodeTable& code, ExprId root) {
  CallUse use;
  model::for_each_expr(code, root, [&](const Expr& e) {
    if (is_division(e.op) && e.type == Type::Int) use.is_droppable = false;
    if (e.op != Op::Call) return;
    use.calls = true;
    for (const FunctionParam& param : code.functions[e.index].params) use.is_droppable &= !param.by_reference;
  });
  return use;
}

// Takes statements out of bodies. Nested as deep as the source, which the parser limits.
class CallRemover {
 public:
  explicit CallRemover(CodeTable& code) : code_(code) {}

  // Calls alone, and stores to variables that are not read.
  void strip(StmtId& first, const std::vector<std::uint8_t>& is_read) {
    StmtId* link = &first;
    while (link->is_valid()) {
      Stmt& s = code_.stmts[*link];
      strip(s.then_body, is_read);
      strip(s.else_body, is_read);
      if (is_droppable(s, is_read)) *link = s.next;
      else link = &s.next;
    }
  }

 private:
  [[nodiscard]] bool is_droppable(const Stmt& s, const std::vector<std::uint8_t>& is_read) const {
    const CallUse use = call_use(code_, s.value);
    if (!use.is_droppable) return false;
    if (const std::optional<std::uint32_t> self = model::assigned_variable(s, Op::LoadSelf))
      return use.calls && !is_read.empty() && is_read[*self] == 0;
    if (model::is_choice(s)) return !s.then_body.is_valid() && !s.else_body.is_valid();
    return use.calls && model::is_evaluation(s);
  }

  CodeTable& code_;
};

// Each piece of code of the system.
template <class SeeExpr, class SeeStmt>
void for_each_code(System& system, const SeeExpr& expr, const SeeStmt& body) {
  for (std::size_t k = 0; k < system.atom_types.size(); ++k) {
    AtomType& type = system.atom_types[AtomTypeId(k)];
    body(type.initial_action);
    expr(type.initial_resume.guard);
    body(type.initial_resume.when.measure);
    for (Transition& t : type.transitions) {
      expr(t.guard);
      body(t.action);
      body(t.when.measure);
      expr(t.resume.guard);
      body(t.resume.when.measure);
    }
    for (const AtomPriority& rule : type.priorities) expr(rule.guard);
    for (Invariant& invariant : type.invariants) {
      expr(invariant.condition);
      body(invariant.when.measure);
    }
  }
  for (std::size_t k = 0; k < system.connector_types.size(); ++k) {
    for (Clause& clause : system.connector_types[ConnectorTypeId(k)].clauses) {
      expr(clause.guard);
      body(clause.up);
      body(clause.down);
    }
  }
  for (std::size_t k = 0; k < system.priorities.size(); ++k) expr(system.priorities[PriorityId(k)].guard);
}

// Types of which there is no component or connector decide nothing, and what they call is none of the system's.
void empty_unused_types(System& system) {
  std::vector<std::uint8_t> is_used(system.atom_types.size());
  for (const Atom& atom : system.atoms) is_used[atom.type.value] = 1;
  for (std::size_t k = 0; k < system.atom_types.size(); ++k) {
    if (is_used[k] != 0) continue;
    AtomType& type = system.atom_types[AtomTypeId(k)];
    type.initial_action = {};
    type.initial_resume = {};
    for (Transition& t : type.transitions) {
      t.guard = {};
      t.action = {};
      t.when = {};
      t.resume = {};
    }
    type.priorities.clear();
    type.invariants.clear();
  }
  std::vector<std::uint8_t> is_bound(system.connector_types.size());
  for (const Connector& connector : system.connectors) is_bound[connector.type.value] = 1;
  for (std::size_t k = 0; k < system.connector_types.size(); ++k) {
    if (is_bound[k] == 0) system.connector_types[ConnectorTypeId(k)].clauses.clear();
  }
}

bool has_calls(System& system) {
  const CodeTable& code = system.code;
  bool result = false;
  const auto look = [&](ExprId root) { result |= call_use(code, root).calls; };
  for_each_code(system, look,
                [&](StmtId first) { model::for_each_stmt(code, first, [&](const Stmt& s) { look(s.value); }); });
  return result;
}

bool has_event_class(const System& system) {
  return std::any_of(system.atom_types.begin(), system.atom_types.end(), [](const AtomType& type) {
    return std::any_of(type.ports.begin(), type.ports.end(),
                       [](const Port& port) { return !port.event_class.empty(); });
  });
}

}  // namespace

bool calls_cpp(const System& system) {
  System used = system;
  empty_unused_types(used);
  return has_calls(used);
}

std::optional<System> without_unread_cpp(const System& system, const std::vector<DataRef>& asked) {
  if (system.code.functions.empty() || !system.code.ffi_types.empty() || has_event_class(system)) return std::nullopt;
  System result = system;
  empty_unused_types(result);
  CallRemover remover(result.code);
  for_each_code(
      result, [](ExprId) {}, [&](StmtId& first) { remover.strip(first, {}); });
  // What calls alone read is not read any more.
  const std::vector<std::vector<std::uint8_t>> is_read =
      find_read_data(result, asked, FaultyAssignments::DivisionsRead);
  for (std::size_t k = 0; k < is_read.size(); ++k) {
    AtomType& type = result.atom_types[AtomTypeId(k)];
    remover.strip(type.initial_action, is_read[k]);
    for (Transition& t : type.transitions) remover.strip(t.action, is_read[k]);
  }
  if (has_calls(result)) return std::nullopt;
  // No code leads to a call: what is left of them names no function.
  for (std::size_t k = 0; k < result.code.exprs.size(); ++k) {
    Expr& e = result.code.exprs[ExprId(k)];
    if (e.op == Op::Call) e = Expr{.op = Op::ConstInt, .loc = e.loc};
  }
  result.code.functions.clear();
  result.code.args.clear();
  result.code.cpp = {};
  return result;
}

}  // namespace bip::verify
