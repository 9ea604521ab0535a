// See unread_data.hpp. By type, over all its instances.
#include "compiler/verify/net/unread_data.hpp"

#include "compiler/model/code_uses.hpp"
#include "compiler/model/operators.hpp"
#include "compiler/system/system.hpp"
#include "compiler/verify/net/abstract_code.hpp"

namespace bip::verify {

namespace {

class DataReaders {
 public:
  DataReaders(const System& system, const std::vector<DataRef>& asked, FaultyAssignments faulty)
      : system_(system), code_(system.code), faulty_(faulty) {
    for (const AtomType& type : system.atom_types) {
      rows_.emplace_back(type.variables.size(), 0);
      for (std::size_t k = type.visible_variables(); k < type.variables.size(); ++k) rows_.back()[k] = 1;
    }
    for (const DataRef& ref : asked) rows_[system.atoms[ref.atom].type.value][ref.variable] = 1;
  }

  std::vector<std::vector<std::uint8_t>> all() {
    for (const Connector& connector : system_.connectors) look_at(connector);
    for (const Priority& rule : system_.priorities) {
      for (const DataRef& ref : rule.data) rows_[system_.atoms[ref.atom].type.value][ref.variable] = 1;
    }
    for (std::size_t k = 0; k < rows_.size(); ++k) look_at(system_.atom_types[AtomTypeId(k)], rows_[k]);
    return std::move(rows_);
  }

 private:
  void mark(const PortRef& ref, std::uint32_t variable) {
    if (ref.kind == PortRef::Kind::Choice) {
      for (const PortRef& port : system_.choices[ref.choice].ports) mark(port, variable);
    } else if (ref.kind == PortRef::Kind::Atom) {
      const AtomTypeId type = system_.atoms[ref.atom].type;
      const std::vector<std::uint32_t>& variables = system_.atom_types[type].ports[ref.port].variables;
      if (variable < variables.size()) rows_[type.value][variables[variable]] = 1;
    }
  }

  void look_at(const Connector& connector) {
    const ConnectorType& type = system_.connector_types[connector.type];
    for (const DataRef& ref : connector.data) rows_[system_.atoms[ref.atom].type.value][ref.variable] = 1;
    const auto see = [&](const Expr& e) {
      if (e.op != Op::LoadBind) return;
      for (std::size_t p = type.params.size(); p-- > 0;) {
        if (e.index < type.params[p].first_bind) continue;
        mark(connector.ports[p], e.index - type.params[p].first_bind);
        return;
      }
    };
    for (const Clause& clause : type.clauses) {
      for_each_expr(code_, clause.guard, see);
      for (const StmtId body : {clause.up, clause.down}) {
        for_each_stmt(code_, body, [&](const Stmt& s) { for_each_expr(code_, s.value, see); });
      }
    }
  }

  void look_at(const AtomType& type, std::vector<std::uint8_t>& row) {
    bool is_changed = false;
    const auto reads = [&](ExprId expr) {
      for_each_expr(code_, expr, [&](const Expr& e) {
        if (e.op != Op::LoadSelf || row[e.index] != 0) return;
        row[e.index] = 1;
        is_changed = true;
      });
    };
    const auto measures = [&](const TimeGuard& when) {
      for_each_stmt(code_, when.measure, [&](const Stmt& s) { reads(s.value); });
    };
    measures(type.initial_resume.when);
    reads(type.initial_resume.guard);
    for (const Transition& t : type.transitions) {
      reads(t.guard);
      measures(t.when);
      reads(t.resume.guard);
      measures(t.resume.when);
    }
    for (const Invariant& invariant : type.invariants) {
      reads(invariant.condition);
      measures(invariant.when);
    }
    for (const AtomPriority& rule : type.priorities) reads(rule.guard);
    const auto close = [&](StmtId body) {
      for_each_stmt(code_, body, [&](const Stmt& s) {
        if (has_effect(s, row)) reads(s.value);
      });
    };
    do {
      is_changed = false;
      close(type.initial_action);
      for (const Transition& t : type.transitions) close(t.action);
    } while (is_changed);
  }

  // Does it matter that the statement is executed? An `if` does not whose statements do not.
  [[nodiscard]] bool has_effect(const Stmt& s, const std::vector<std::uint8_t>& row) const {
    bool result = has_effect_alone(s, row);
    for (const StmtId body : {s.then_body, s.else_body}) {
      for_each_stmt(code_, body, [&](const Stmt& inner) { result = result || has_effect_alone(inner, row); });
    }
    return result;
  }
  // The same without its branches.
  [[nodiscard]] bool has_effect_alone(const Stmt& s, const std::vector<std::uint8_t>& row) const {
    if (counts(s.value)) return true;
    if (const std::optional<std::uint32_t> self = model::assigned_variable(s, Op::LoadSelf)) return row[*self] != 0;
    return !model::is_choice(s);
  }

  [[nodiscard]] bool counts(ExprId value) const {
    bool divides = false, calls = false;
    for_each_expr(code_, value, [&](const Expr& e) {
      divides |= is_division(e.op) && e.type == Type::Int;
      calls |= e.op == Op::Call;
    });
    switch (faulty_) {
      case FaultyAssignments::Read: return divides || calls;
      case FaultyAssignments::DivisionsRead: return divides;
      case FaultyAssignments::Ignored: break;
    }
    return false;
  }

  const System& system_;
  const CodeTable& code_;
  FaultyAssignments faulty_;
  std::vector<std::vector<std::uint8_t>> rows_;
};

// A copy of the body without the stores. Nested as deep as the source, which the parser limits.
StmtId strip(CodeTable& code, StmtId body, const std::vector<std::uint8_t>& is_read) {
  StmtId first;
  StmtId last;
  for (StmtId id = body; id.is_valid(); id = code.stmts[id].next) {
    Stmt copy = code.stmts[id];
    const std::optional<std::uint32_t> variable = model::assigned_variable(copy, Op::LoadSelf);
    if (variable && is_read[*variable] == 0) continue;
    copy.then_body = strip(code, copy.then_body, is_read);
    copy.else_body = strip(code, copy.else_body, is_read);
    copy.next = {};
    const StmtId made = code.stmts.push(copy);
    if (last.is_valid()) code.stmts[last].next = made;
    else first = made;
    last = made;
  }
  return first;
}

}  // namespace

std::vector<std::vector<std::uint8_t>> find_read_data(const System& system, const std::vector<DataRef>& asked,
                                                      FaultyAssignments faulty) {
  return DataReaders(system, asked, faulty).all();
}

std::vector<rt::VariableId> find_unread_cells(const System& system, const rt::Image& image,
                                              const std::vector<DataRef>& asked) {
  const std::vector<std::vector<std::uint8_t>> is_read = find_read_data(system, asked, FaultyAssignments::Read);
  std::vector<rt::VariableId> cells;
  for (std::uint32_t atom = 0; atom < system.atoms.size(); ++atom) {
    const AtomTypeId type = system.atoms[AtomId(std::size_t{atom})].type;
    const std::vector<DataVariable>& variables = system.atom_types[type].variables;
    for (std::uint32_t k = 0; k < variables.size(); ++k) {
      const bool is_number = !is_ffi(variables[k].type) && variables[k].type != Type::String;
      if (is_number && is_read[type.value][k] == 0) cells.push_back(image.atoms[atom].variable(k));
    }
  }
  return cells;
}

System without_unread_data(const System& system, const std::vector<std::vector<std::uint8_t>>& is_read) {
  System result = system;
  for (std::size_t k = 0; k < is_read.size(); ++k) {
    AtomType& type = result.atom_types[AtomTypeId(k)];
    type.initial_action = strip(result.code, type.initial_action, is_read[k]);
    for (Transition& t : type.transitions) t.action = strip(result.code, t.action, is_read[k]);
  }
  return result;
}

}  // namespace bip::verify
