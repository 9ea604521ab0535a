// Promises of code.hpp: trees, types, variables in range and of the right type, parameters never written.
//
// Two walks, both iterative. The first marks every row that some guard or body reaches and finds rows with two parents,
// cycles and depth; each row is met once. The second follows each use of a piece of code with the variables of its
// owner (a guard may serve many priorities): linear in the uses, that is, in the printed text. Needs sound types and
// instances.
#include "compiler/model/statements.hpp"
#include "compiler/system/bsys_text.hpp"
#include "compiler/system/validate_problems.hpp"

namespace bip::system {
namespace {

using namespace text;

/// Which variables a piece of code may write.
enum class Writes : std::uint8_t { Nothing, Self, SelfAndBind };

/// A row of the code with its nesting depth.
struct Visit {
  std::uint32_t row = 0;
  std::uint32_t depth = 0;
  bool is_stmt = false;
};

class CodeChecker {
 public:
  CodeChecker(const System& system, Problems& problems)
      : system_(system),
        code_(system.code),
        problems_(problems),
        expr_marks_(system.code.exprs.size(), Mark::New),
        stmt_marks_(system.code.stmts.size(), Mark::New) {}

  void guard(ExprId id, const CodeScope& scope) {
    if (!id.is_valid() || !reach({id.value, 0, false})) return;
    problems_.expect(code_.exprs[id].type == Type::Bool, "a guard is not a bool");
    check({id.value, 0, false}, scope, Writes::Nothing);
  }
  void body(StmtId id, const CodeScope& scope, Writes writes) {
    if (id.is_valid() && reach({id.value, 0, true})) check({id.value, 0, true}, scope, writes);
  }

 private:
  enum class Mark : std::uint8_t { New, Root, Inner, Broken };

  /// First walk. False if the tree under this root is broken (now or when it was met before).
  bool reach(const Visit& root) {
    const bool in_range =
        root.is_stmt ? code_.stmts.contains(StmtId(root.row)) : code_.exprs.contains(ExprId(root.row));
    if (!problems_.expect(in_range, "code is no row")) return false;
    Mark& mark = mark_of(root);
    if (mark == Mark::Root) return true;
    if (!problems_.expect(mark == Mark::New, "a row of code is a part of another one")) return false;
    mark = Mark::Root;
    stack_.assign(1, root);
    while (!stack_.empty()) {
      const Visit at = stack_.back();
      stack_.pop_back();
      if (!(at.is_stmt ? reach_from_stmt(at) : reach_from_expr(at))) {
        mark_of(root) = Mark::Broken;
        return false;
      }
    }
    return true;
  }
  Mark& mark_of(const Visit& visit) { return visit.is_stmt ? stmt_marks_[visit.row] : expr_marks_[visit.row]; }

  bool push_part(const Visit& part) {
    const bool in_range = part.is_stmt ? part.row < stmt_marks_.size() : part.row < expr_marks_.size();
    if (!problems_.expect(in_range, "a part of a row of code is no row")) return false;
    if (!problems_.expect(mark_of(part) == Mark::New, "a row of code is a part of two")) return false;
    if (!problems_.expect(part.depth <= kMaxCodeDepth, "code is nested too deep")) return false;
    mark_of(part) = Mark::Inner;
    stack_.push_back(part);
    return true;
  }
  bool reach_from_expr(const Visit& at) {
    const Expr& e = code_.exprs[ExprId(at.row)];
    if (!problems_.expect(is_operator(e.op) && is_type(system_, e.type), "an expression has no operator or no type"))
      return false;
    check_loc(system_, e.loc, problems_);
    if (e.op == Op::Call) return reach_from_call(e, at);
    const int count = operand_count(e.op);
    return (count < 1 || push_part({e.a.value, at.depth + 1, false})) &&
           (count < 2 || push_part({e.b.value, at.depth + 1, false}));
  }
  bool reach_from_call(const Expr& e, const Visit& at) {
    if (!problems_.expect(e.index < code_.functions.size(), "a call's function is no row")) return false;
    const std::size_t count = code_.functions[e.index].params.size();
    const bool in_range = e.int_value >= 0 && static_cast<std::size_t>(e.int_value) + count <= code_.args.size();
    if (!problems_.expect(in_range, "a call's arguments are no rows")) return false;
    for (const ExprId arg : code_.args_of(e)) {
      if (!push_part({arg.value, at.depth + 1, false})) return false;
    }
    return true;
  }
  bool reach_from_stmt(const Visit& at) {
    const Stmt& s = code_.stmts[StmtId(at.row)];
    if (!problems_.expect(static_cast<std::size_t>(s.op) < kStatements.size(), "a statement has no operator"))
      return false;
    check_loc(system_, s.loc, problems_);
    if (!push_part({s.value.value, at.depth + 1, false})) return false;
    for (const StmtId branch : {s.then_body, s.else_body}) {
      if (branch.is_valid() && !push_part({branch.value, at.depth + 1, true})) return false;
    }
    return !s.next.is_valid() || push_part({s.next.value, at.depth, true});
  }

  /// Second walk, over a sound tree.
  void check(const Visit& root, const CodeScope& scope, Writes writes) {
    stack_.assign(1, root);
    while (!stack_.empty()) {
      const Visit at = stack_.back();
      stack_.pop_back();
      if (at.is_stmt) {
        const Stmt& s = code_.stmts[StmtId(at.row)];
        check_stmt(s, scope, writes);
        stack_.push_back({s.value.value, 0, false});
        for (const StmtId part : {s.then_body, s.else_body, s.next}) {
          if (part.is_valid()) stack_.push_back({part.value, 0, true});
        }
      } else {
        const Expr& e = code_.exprs[ExprId(at.row)];
        check_expr(e, scope);
        if (operand_count(e.op) >= 1) stack_.push_back({e.a.value, 0, false});
        if (operand_count(e.op) == 2) stack_.push_back({e.b.value, 0, false});
        if (e.op != Op::Call) continue;
        check_call(e, scope, writes);
        for (const ExprId arg : code_.args_of(e)) stack_.push_back({arg.value, 0, false});
      }
    }
  }

  void check_call(const Expr& e, const CodeScope& scope, Writes writes) {
    const Function& function = code_.functions[e.index];
    const std::span<const ExprId> args = code_.args_of(e);
    problems_.expect(e.type == function.result, "a call has not its function's type");
    if (function.kind == FunctionKind::Draw && !args.empty()) {
      const Expr& generator = code_.exprs[args[0]];
      problems_.expect(generator.op == Op::LoadSelf && generator.index == scope.draws,
                       "a draw is not from the generator of the atom");
    }
    for (std::size_t k = 0; k < args.size(); ++k) {
      const Expr& arg = code_.exprs[args[k]];
      problems_.expect(arg.type == function.params[k].type, "an argument has not its parameter's type");
      problems_.expect(arg.op != Op::Call || code_.functions[arg.index].has_result,
                       "a call without a result is used as a value");
      if (!function.params[k].by_reference) continue;
      const bool is_self = arg.op == Op::LoadSelf;
      const std::vector<ScopeVariable>& variables = is_self ? scope.self : scope.bind;
      const bool is_variable =
          (is_self || arg.op == Op::LoadBind) && arg.index < variables.size() && variables[arg.index].writable;
      problems_.expect(is_variable && (is_self ? writes != Writes::Nothing : writes == Writes::SelfAndBind),
                       "an argument by reference is no variable that may change here");
    }
  }

  void check_stmt(const Stmt& s, const CodeScope& scope, Writes writes) {
    const Expr& given = code_.exprs[s.value];
    const StmtInfo& info = info_of(s.op);
    problems_.expect(info.shape == StmtShape::Chooses || (!s.then_body.is_valid() && !s.else_body.is_valid()),
                     "a statement without a condition has branches");
    problems_.expect(info.value == StmtValue::Call || given.op != Op::Call || code_.functions[given.index].has_result,
                     "a call without a result is used as a value");
    switch (info.shape) {
      case StmtShape::StoresSelf: check_store(s, scope.self); break;
      case StmtShape::StoresBind:
        check_store(s, scope.bind);
        problems_.expect(writes == Writes::SelfAndBind, "an assignment to a port's variable outside `down`");
        break;
      case StmtShape::Chooses:
      case StmtShape::Evaluates: break;
    }
    switch (info.value) {
      case StmtValue::OfVariable: break;
      case StmtValue::Condition: problems_.expect(given.type == Type::Bool, "a condition is not a bool"); break;
      case StmtValue::Call: problems_.expect(given.op == Op::Call, "a statement that calls has no call"); break;
    }
  }
  void check_store(const Stmt& s, const std::vector<ScopeVariable>& variables) {
    if (!problems_.expect(s.index < variables.size(), "an assignment to no variable")) return;
    problems_.expect(s.type == variables[s.index].type && s.type == code_.exprs[s.value].type,
                     "an assignment of another type");
    problems_.expect(variables[s.index].writable, "an assignment to a read-only variable");
  }

  void check_expr(const Expr& e, const CodeScope& scope) {
    bool sound = false;
    switch (e.op) {
      case Op::ConstInt: sound = e.type == Type::Int; break;
      case Op::ConstFloat: sound = e.type == Type::Float; break;
      case Op::ConstBool: sound = e.type == Type::Bool && (e.int_value == 0 || e.int_value == 1); break;
      case Op::ConstString:
        sound = e.type == Type::String && static_cast<std::uint32_t>(e.int_value) < code_.strings.size();
        break;
      case Op::LoadSelf: sound = e.index < scope.self.size() && scope.self[e.index].type == e.type; break;
      case Op::LoadBind: sound = e.index < scope.bind.size() && scope.bind[e.index].type == e.type; break;
      case Op::Call:
        sound = true;
        break;
        BIP_UNARY_OPS(BIP_OP_CASE)
        BIP_BINARY_OPS(BIP_OP_CASE) {
          const Type a = code_.exprs[e.a].type;
          sound = takes(info_of(e.op).operands, a) && e.type == result_of(e.op, a) &&
                  (operand_count(e.op) == 1 || code_.exprs[e.b].type == a);
          break;
        }
    }
    if (!sound) problems_.add("an expression has the wrong type, variable or constant");
  }

  const System& system_;
  const CodeTable& code_;
  Problems& problems_;
  std::vector<Mark> expr_marks_, stmt_marks_;
  std::vector<Visit> stack_;
};

}  // namespace

void check_code(const System& system, Problems& problems) {
  CodeChecker checker(system, problems);
  for (std::size_t k = 0; k < system.atom_types.size(); ++k) {
    const AtomType& type = system.atom_types.rows()[k];
    const CodeScope scope = scope_of(type);
    problems.at(Table::AtomTypes, k);
    checker.body(type.initial_action, scope, Writes::Self);
    const auto resume = [&](const Resume& row) {
      checker.guard(row.guard, scope);
      checker.body(row.when.measure, scope, Writes::Self);
    };
    resume(type.initial_resume);
    for (const Transition& transition : type.transitions) {
      checker.guard(transition.guard, scope);
      checker.body(transition.when.measure, scope, Writes::Self);
      checker.body(transition.action, scope, Writes::Self);
      resume(transition.resume);
    }
    for (const AtomPriority& row : type.priorities) checker.guard(row.guard, scope);
    for (const Invariant& row : type.invariants) {
      checker.guard(row.condition, scope);
      checker.body(row.when.measure, scope, Writes::Self);
    }
  }
  for (std::size_t k = 0; k < system.connector_types.size(); ++k) {
    const ConnectorType& type = system.connector_types.rows()[k];
    const CodeScope scope = scope_of(system, type);
    problems.at(Table::ConnectorTypes, k);
    for (const Clause& clause : type.clauses) {
      checker.guard(clause.guard, scope);
      checker.body(clause.up, scope, Writes::Self);
      checker.body(clause.down, scope, Writes::SelfAndBind);
    }
  }
  for (std::size_t k = 0; k < system.priorities.size(); ++k) {
    const Priority& row = system.priorities.rows()[k];
    problems.at(Table::Priorities, k);
    if (row.guard.is_valid()) checker.guard(row.guard, scope_of(system, row));
  }
}

}  // namespace bip::system
