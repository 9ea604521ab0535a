// Emits guards, actions and transfers as C++ functions with the model's names.
//
// A function declares the variables that it uses as references into the cells; its body then resembles the source. A
// function that divides ints is a function-try-block: the first fault ends it with the site's status, as rt::CodeFn
// requires. Linear in the code. Recursion follows nested ifs and expressions, whose depth the parser limits; else-if
// chains are followed in a loop.
#include "compiler/emit_cpp/functions.hpp"

#include <algorithm>

#include "compiler/model/operators.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::emit_cpp {

LocalNames::LocalNames() {
  for (const std::string_view word : reserved_words()) names_.reserve(word);
  for (const OperatorInfo& op : kOperators) {
    if (op.function != nullptr) names_.reserve(op.function);
  }
}

std::string LocalNames::make(std::string_view name) {
  std::string text(name);
  // A name without small letters could be a macro of some header.
  const bool small = std::any_of(text.begin(), text.end(), [](char c) { return c >= 'a' && c <= 'z'; });
  if (!small && text.size() > 1) {
    for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return names_.make(text);
}

namespace {

std::string variable_type(const FfiNames& ffi, Type type, bool on_cells) {
  if (is_ffi(type)) return "FfiVariable<" + ffi.type(type) + ">";
  switch (type) {
    case Type::Bool: return on_cells ? "BoolCell" : "BoolVar";
    case Type::Float: return "FloatVar";
    case Type::String: return on_cells ? "StringCell" : "StringVar";
    case Type::Int: break;
  }
  return on_cells ? "IntCell" : "IntVar";
}

// The model's names of all Bind variables of a unit's owner, in order.
std::vector<std::string> bind_names(const System& system, const lower::CodeUnit& unit) {
  std::vector<std::string> names;
  if (unit.owner == lower::CodeOwner::Connector) {
    const ConnectorType& type = system.connector_types[ConnectorTypeId(unit.owner_row)];
    for (const ConnectorParam& param : type.params) {
      for (const Variable& v : system.port_types[param.type].variables) names.push_back(param.name + "." + v.name);
    }
    for (const DataRead& read : type.data_reads) names.push_back(read.path);
  } else if (unit.owner == lower::CodeOwner::Priority) {
    for (const DataRef& ref : system.priorities[PriorityId(unit.owner_row)].data) {
      const Atom& atom = system.atoms[ref.atom];
      names.push_back(atom.path + "." + system.atom_types[atom.type].variables[ref.variable].name);
    }
  }
  return names;
}

const std::vector<DataVariable>* self_variables(const System& system, const lower::CodeUnit& unit) {
  switch (unit.owner) {
    case lower::CodeOwner::Atom: return &system.atom_types[AtomTypeId(unit.owner_row)].variables;
    case lower::CodeOwner::Connector: return &system.connector_types[ConnectorTypeId(unit.owner_row)].variables;
    case lower::CodeOwner::Priority: break;
  }
  return nullptr;
}

// The variables that one unit uses, found in one walk over its code.
class Uses {
 public:
  Uses(const CodeTable& code, std::size_t self_count, std::size_t bind_count)
      : self(self_count), bind(bind_count), code_(code) {}

  void add(ExprId id) {
    if (!id.is_valid()) return;
    const Expr& e = code_.exprs[id];
    if (e.op == Op::LoadSelf) note(self, e.index, e.type, Access::Read);
    if (e.op == Op::LoadBind) note(bind, e.index, e.type, Access::Read);
    if (e.op == Op::Call) add_call(e);
    if (operand_count(e.op) >= 1) add(e.a);
    if (operand_count(e.op) == 2) add(e.b);
    faults = faults || (is_division(e.op) && e.type == Type::Int);
  }
  void add_call(const Expr& e) {
    faults = true;
    const std::span<const ExprId> args = code_.args_of(e);
    for (std::size_t k = 0; k < args.size(); ++k) {
      const Expr& arg = code_.exprs[args[k]];
      const bool by_reference = code_.functions[e.index].params[k].by_reference;
      if (by_reference) note(arg.op == Op::LoadSelf ? self : bind, arg.index, arg.type, Access::Written);
      else add(args[k]);
    }
  }
  void add(StmtId first) {
    for (StmtId id = first; id.is_valid(); id = code_.stmts[id].next) {
      const Stmt& s = code_.stmts[id];
      add(s.value);
      switch (s.op) {
        case StmtOp::StoreSelf: note(self, s.index, s.type, Access::Written); break;
        case StmtOp::StoreBind: note(bind, s.index, s.type, Access::Written); break;
        case StmtOp::If:
          add(s.then_body);
          add(s.else_body);
          break;
        case StmtOp::Call: break;
      }
    }
  }
  /// Names the used variables, each by its row.
  void name(LocalNames& names, const std::vector<DataVariable>* cells, const std::vector<std::string>& binds) {
    for (std::size_t k = 0; k < self.size(); ++k) {
      if (used(self[k])) self[k].name = names.make((*cells)[k].name);
    }
    for (std::size_t k = 0; k < bind.size(); ++k) {
      if (used(bind[k])) bind[k].name = names.make(binds[k]);
    }
  }
  [[nodiscard]] static bool used(const Local& local) { return local.index != rt::kNone; }
  [[nodiscard]] static bool any(const std::vector<Local>& locals) {
    return std::any_of(locals.begin(), locals.end(), used);
  }

  std::vector<Local> self, bind;
  bool faults = false;

 private:
  enum class Access : std::uint8_t { Read, Written };
  static void note(std::vector<Local>& locals, std::uint32_t index, Type type, Access access) {
    BIP_ASSERT(index < locals.size(), "variable {} of {}", index, locals.size());
    Local& local = locals[index];
    BIP_ASSERT(local.index == rt::kNone || local.type == type, "variable {} is used as two types", index);
    local.index = index;
    local.type = type;
    local.written = local.written || access == Access::Written;
  }
  const CodeTable& code_;
};

class FunctionEmitter {
 public:
  /// distance: 0 for functions on cells, else on cells, with self's variables so far from each other.
  FunctionEmitter(const lower::LoweredSystem& lowered, CppWriter& out, std::uint32_t distance = 0)
      : lowered_(lowered),
        code_(lowered.system->code),
        out_(out),
        distance_(distance),
        faults_(lowered),
        ffi_(lowered.system->code) {}

  void emit(const lower::CodeUnit& unit);

 private:
  enum class VariableKind : std::uint8_t { Self, Bind };
  void declare(const std::vector<Local>& locals, VariableKind kind);
  void body(ExprContext& context, StmtId first, int depth);
  void if_chain(ExprContext& context, StmtId id, int depth);
  void assignment(ExprContext& context, const std::vector<Local>& locals, const Stmt& stmt, int depth);
  void indented(int depth, const std::string& text) {
    out_.line(std::string(static_cast<std::size_t>(depth) * 2, ' ') + text);
  }

  const lower::LoweredSystem& lowered_;
  const CodeTable& code_;
  CppWriter& out_;
  std::uint32_t distance_;
  FaultInfo faults_;
  FfiNames ffi_;
};

void FunctionEmitter::declare(const std::vector<Local>& locals, VariableKind kind) {
  const bool is_bind = kind == VariableKind::Bind;
  for (const Local& local : locals) {
    if (!Uses::used(local)) continue;
    const std::string row =
        std::to_string(local.index) + (is_bind || distance_ < 2 ? "" : " * " + std::to_string(distance_));
    const std::string cell = is_bind ? "all[bind[" + row + "]]" : "self[" + row + "]";
    indented(1, std::string(local.written ? "" : "const ") + variable_type(ffi_, local.type, distance_ != 0) + " " +
                    local.name + "{" + cell + "};");
  }
}

void FunctionEmitter::if_chain(ExprContext& context, StmtId id, int depth) {
  const Stmt* stmt = &code_.stmts[id];
  indented(depth, "if (" + expr_text(context, stmt->value) + ") {");
  body(context, stmt->then_body, depth + 1);
  while (stmt->else_body.is_valid()) {
    const Stmt& next = code_.stmts[stmt->else_body];
    if (next.op != StmtOp::If || next.next.is_valid()) {
      indented(depth, "} else {");
      body(context, stmt->else_body, depth + 1);
      break;
    }
    stmt = &next;
    out_.at(stmt->loc);
    indented(depth, "} else if (" + expr_text(context, stmt->value) + ") {");
    body(context, stmt->then_body, depth + 1);
  }
  indented(depth, "}");
}

void FunctionEmitter::body(ExprContext& context, StmtId first, int depth) {
  for (StmtId id = first; id.is_valid(); id = code_.stmts[id].next) {
    const Stmt& stmt = code_.stmts[id];
    out_.at(stmt.loc);
    switch (stmt.op) {
      case StmtOp::StoreSelf: assignment(context, context.self_locals, stmt, depth); break;
      case StmtOp::StoreBind: assignment(context, context.bind_locals, stmt, depth); break;
      case StmtOp::If: if_chain(context, id, depth); break;
      case StmtOp::Call: indented(depth, expr_text(context, stmt.value) + ";"); break;
    }
  }
}

void FunctionEmitter::assignment(ExprContext& context, const std::vector<Local>& locals, const Stmt& stmt, int depth) {
  BIP_ASSERT(Uses::used(locals[stmt.index]) && locals[stmt.index].written,
             "variable {} is assigned, and was declared constant", stmt.index);
  indented(depth, locals[stmt.index].name + " = " + expr_text(context, stmt.value) + ";");
}

void FunctionEmitter::emit(const lower::CodeUnit& unit) {
  const System& system = *lowered_.system;
  const std::vector<DataVariable>* variables = self_variables(system, unit);
  const std::vector<std::string> binds = bind_names(system, unit);
  Uses uses(code_, variables != nullptr ? variables->size() : 0, binds.size());
  uses.add(unit.expr);
  uses.add(unit.body);
  LocalNames names;
  uses.name(names, variables, binds);
  const bool has_self = Uses::any(uses.self);
  const bool has_bind = Uses::any(uses.bind);

  const std::string cell_pointer = distance_ != 0 ? "ColumnCell*" : "Cell*";
  std::string head = "std::int32_t " + unit.name + "(const void*, " + cell_pointer;
  head += has_self ? " self" : "";
  head += ", " + cell_pointer + (has_bind ? " all, const std::uint32_t* bind)" : ", const std::uint32_t*)");
  out_.line();
  if (!out_.has_line_directives()) out_.line("// " + out_.place(unit.loc));
  out_.at(unit.loc);
  out_.line(head + (uses.faults ? " try {" : " {"));
  declare(uses.self, VariableKind::Self);
  declare(uses.bind, VariableKind::Bind);
  ExprContext context{lowered_, faults_, names, ffi_, uses.self, uses.bind};
  if (unit.kind == lower::CodeKind::Guard) {
    const std::string value = expr_text(context, unit.expr);
    out_.at(unit.loc);
    indented(1, "return " + value + ";");
  } else {
    body(context, unit.body, 1);
    indented(1, "return 1;");
  }
  if (uses.faults) {
    out_.line("} catch (const CodeFault& fault) {");
    indented(1, "return fault.status;");
  }
  out_.line("}");
}

}  // namespace

void emit_functions(const lower::LoweredSystem& lowered, CppWriter& out) {
  FunctionEmitter emitter(lowered, out);
  for (const lower::CodeUnit& unit : lowered.units) emitter.emit(unit);
  out.at_emitted();
}

void emit_on_cells(const lower::LoweredSystem& lowered, std::uint32_t unit, std::uint32_t distance, CppWriter& out) {
  BIP_ASSERT(unit < lowered.units.size() && distance != 0, "unit {} at distance {}", unit, distance);
  FunctionEmitter(lowered, out, distance).emit(lowered.units[unit]);
}

}  // namespace bip::emit_cpp
