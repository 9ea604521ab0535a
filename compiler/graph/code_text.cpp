// See code_text.hpp.
#include "compiler/graph/code_text.hpp"

#include <fmt/format.h>

#include <cmath>

#include "compiler/base/assert.hpp"
#include "compiler/base/quote.hpp"
#include "compiler/system/bsys_text.hpp"

namespace bip::graph {
namespace {

/// How tight an operator binds; operands that bind less tight stand in parentheses.
constexpr int kLoosest = 0, kUnary = 10, kPrimary = 11;
int tightness(Op op) {
  switch (op) {
    case Op::Or: return 1;
    case Op::And: return 2;
    case Op::BitOr: return 3;
    case Op::BitXor: return 4;
    case Op::BitAnd: return 5;
    case Op::Eq:
    case Op::Ne: return 6;
    case Op::Lt:
    case Op::Gt:
    case Op::Le:
    case Op::Ge: return 7;
    case Op::Add:
    case Op::Sub: return 8;
    case Op::Mul:
    case Op::Div:
    case Op::Mod: return 9;
    case Op::Neg:
    case Op::Not:
    case Op::BitNot: return kUnary;
    default: return kPrimary;
  }
}

const char* sign_of(Op op) {
  switch (op) {
    case Op::Or: return "||";
    case Op::And: return "&&";
    case Op::BitOr: return "|";
    case Op::BitXor: return "^";
    case Op::BitAnd: return "&";
    case Op::Eq: return "==";
    case Op::Ne: return "!=";
    case Op::Lt: return "<";
    case Op::Gt: return ">";
    case Op::Le: return "<=";
    case Op::Ge: return ">=";
    case Op::Add: return "+";
    case Op::Sub:
    case Op::Neg: return "-";
    case Op::Mul: return "*";
    case Op::Div: return "/";
    case Op::Mod: return "%";
    case Op::Not: return "!";
    case Op::BitNot: return "~";
    default: return "";
  }
}

std::string float_text(double value) {
  // The payload and the sign of a NaN are invisible to models.
  if (std::isnan(value)) return "nan";
  std::string digits = fmt::format("{}", value);
  if (digits.find_first_not_of("-0123456789") == std::string::npos) digits += ".0";
  return digits;
}

class CodeTextWriter {
 public:
  CodeTextWriter(const CodeTable& code, const CodeNames& names) : code_(code), names_(names) {}

  void expr(ExprId id, int context) {
    const Expr& e = code_.exprs[id];
    if (e.op == Op::IntToFloat) return expr(e.a, context);
    const bool negative = (e.op == Op::ConstInt && e.int_value < 0) || (e.op == Op::ConstFloat && e.float_value < 0);
    const int own = negative ? kUnary : tightness(e.op);
    if (own < context) out_ += '(';
    switch (e.op) {
      case Op::ConstInt:
      case Op::ConstBool:
      case Op::ConstFloat:
      case Op::ConstString:
        out_ += text_of(code_, Value{.type = e.type, .int_value = e.int_value, .float_value = e.float_value});
        break;
      case Op::LoadSelf: out_ += names_.self[e.index]; break;
      case Op::LoadBind: out_ += names_.bind[e.index]; break;
      case Op::Call: call(e); break;
      case Op::Neg:
      case Op::Not:
      case Op::BitNot:
        out_ += sign_of(e.op);
        // `- -x` would be read as it stands, but not by people.
        expr(e.a, e.op == Op::Neg ? kPrimary : kUnary);
        break;
      default: {
        // Comparisons do not chain.
        const bool compares = own == tightness(Op::Eq) || own == tightness(Op::Lt);
        expr(e.a, compares ? tightness(Op::Add) : own);
        out_.append(" ").append(sign_of(e.op)).append(" ");
        expr(e.b, compares ? tightness(Op::Add) : own + 1);
      }
    }
    if (own < context) out_ += ')';
  }

  void stmts(StmtId first) {
    const std::size_t begin = out_.size();
    for (StmtId id = first; id.is_valid(); id = code_.stmts[id].next) {
      const Stmt& s = code_.stmts[id];
      const bool is_store = s.op == StmtOp::StoreSelf || s.op == StmtOp::StoreBind;
      const std::string& target =
          is_store ? (s.op == StmtOp::StoreSelf ? names_.self : names_.bind)[s.index] : std::string();
      if (is_store && target.empty()) continue;
      if (out_.size() > begin) out_ += ' ';
      if (s.op == StmtOp::If) {
        out_ += "if (";
        expr(s.value, kLoosest);
        out_ += ") then ";
        stmts(s.then_body);
        if (s.else_body.is_valid()) {
          out_ += " else ";
          stmts(s.else_body);
        }
        out_ += " fi";
        continue;
      }
      if (is_store) out_ += target + " = ";
      expr(s.value, kLoosest);
      out_ += ';';
    }
  }

  std::string take() { return std::move(out_); }

 private:
  void call(const Expr& e) {
    const Function& function = code_.functions[e.index];
    const std::span<const ExprId> args = code_.args_of(e);
    // Signs of extern operators have no tightness of their own here: they get parentheses.
    const bool is_sign = function.kind == FunctionKind::Operator;
    out_ += is_sign ? "(" : function.kind == FunctionKind::Cast ? "" : function.name + "(";
    if (is_sign && args.size() == 1) out_ += function.name;
    for (std::size_t k = 0; k < args.size(); ++k) {
      if (k > 0) out_ += is_sign ? " " + function.name + " " : ", ";
      expr(args[k], is_sign ? kUnary : kLoosest);
    }
    out_ += function.kind == FunctionKind::Cast ? "" : ")";
  }

  const CodeTable& code_;
  const CodeNames& names_;
  std::string out_;
};

std::vector<std::string> names_in(const std::vector<system::text::ScopeVariable>& variables) {
  std::vector<std::string> names;
  for (const system::text::ScopeVariable& variable : variables) names.push_back(variable.name);
  return names;
}

// The value that `measure` stores in a hidden variable.
ExprId limit_of(const CodeTable& code, StmtId measure, std::uint32_t variable) {
  for (StmtId id = measure; id.is_valid(); id = code.stmts[id].next)
    if (code.stmts[id].op == StmtOp::StoreSelf && code.stmts[id].index == variable) return code.stmts[id].value;
  return {};
}

const char* sign_of(BoundOp op) {
  switch (op) {
    case BoundOp::Lt: return " < ";
    case BoundOp::Le: return " <= ";
    case BoundOp::Gt: return " > ";
    case BoundOp::Ge: return " >= ";
    case BoundOp::Eq: return " == ";
  }
  BIP_UNREACHABLE("bound");
}

}  // namespace

CodeNames names_of(const AtomType& type) {
  CodeNames names{.self = names_in(system::text::scope_of(type).self)};
  for (const Clock& clock : type.clocks) {
    names.self[clock.variable + static_cast<std::uint32_t>(ClockVariable::Value)] = clock.name;
    names.self[clock.variable + static_cast<std::uint32_t>(ClockVariable::IsSet)].clear();
    names.self[clock.variable + static_cast<std::uint32_t>(ClockVariable::Speed)] = clock.name + "'";
  }
  return names;
}

CodeNames names_of(const System& system, const ConnectorType& type) {
  const system::text::CodeScope scope = system::text::scope_of(system, type);
  return {names_in(scope.self), names_in(scope.bind)};
}

CodeNames names_of(const System& system, const Priority& priority) {
  return {.bind = names_in(system::text::scope_of(system, priority).bind)};
}

std::string text_of(const CodeTable& code, ExprId expr, const CodeNames& names) {
  if (!expr.is_valid()) return {};
  CodeTextWriter writer(code, names);
  writer.expr(expr, kLoosest);
  return writer.take();
}

std::string text_of(const CodeTable& code, StmtId first, const CodeNames& names) {
  CodeTextWriter writer(code, names);
  writer.stmts(first);
  return writer.take();
}

std::string text_of(const CodeTable& code, const Value& value) {
  switch (value.type) {
    case Type::Int: return std::to_string(value.int_value);
    case Type::Bool: return value.int_value != 0 ? "true" : "false";
    case Type::String: return quoted(code.strings[static_cast<std::size_t>(value.int_value)]);
    default: return float_text(value.float_value);
  }
}

std::string condition_of(const CodeTable& code, const AtomType& type, ExprId guard, const TimeGuard& when) {
  const CodeNames names = names_of(type);
  std::string out;
  if (guard.is_valid()) {
    CodeTextWriter writer(code, names);
    writer.expr(guard, when.bounds.empty() ? kLoosest : tightness(Op::And));
    out = writer.take();
  }
  for (const Bound& bound : when.bounds) {
    if (!out.empty()) out += " && ";
    const Clock& clock = type.clocks[bound.clock];
    out += clock.name;
    if (bound.minus != Bound::kNone) out += " - " + type.clocks[bound.minus].name;
    out += sign_of(bound.op);
    const ExprId limit = bound.variable == Bound::kNone ? ExprId() : limit_of(code, when.measure, bound.variable);
    if (limit.is_valid()) {
      CodeTextWriter writer(code, names);
      writer.expr(limit, tightness(Op::Add));
      out += writer.take();
    } else if (bound.variable != Bound::kNone) {
      out += type.variables[bound.variable].name;
    } else {
      out += fmt::format("{}", static_cast<double>(bound.ticks) / static_cast<double>(clock.unit));
    }
  }
  return out;
}

std::string define_of(const ConnectorType& type) {
  std::string out;
  // Preorder rows, so one pass; `open` holds the groups that still lack children.
  struct Group {
    std::size_t left;
    const char* end;
  };
  std::vector<Group> open;
  for (const DefineNode& node : type.define) {
    if (!out.empty() && out.back() != '(') out += ' ';
    if (!node.is_leaf) {
      const bool is_root = open.empty();
      if (!is_root) out += '(';
      open.push_back({node.children.size(), is_root ? "" : node.trigger ? ")'" : ")"});
      continue;
    }
    out += type.params[node.param].name;
    if (node.trigger) out += '\'';
    while (!open.empty() && --open.back().left == 0) {
      out += open.back().end;
      open.pop_back();
    }
  }
  return out;
}

std::string list_of(const std::vector<std::uint32_t>& rows, const std::vector<std::string>& names,
                    std::string_view between) {
  std::string out;
  for (const std::uint32_t row : rows) {
    if (!out.empty()) out += between;
    out += names[row];
  }
  return out;
}

}  // namespace bip::graph
