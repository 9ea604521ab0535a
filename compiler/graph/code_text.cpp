// See code_text.hpp.
#include "compiler/graph/code_text.hpp"

#include <fmt/format.h>

#include <cmath>

#include "compiler/base/quote.hpp"
#include "compiler/model/code_uses.hpp"
#include "compiler/model/print_expr.hpp"
#include "compiler/system/bsys_text.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::graph {
namespace {

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

  ExprText expr(ExprId id) {
    const Expr& e = code_.exprs[id];
    switch (e.op) {
      case Op::ConstInt:
      case Op::ConstBool:
      case Op::ConstFloat:
      case Op::ConstString: {
        const bool negative =
            (e.op == Op::ConstInt && e.int_value < 0) || (e.op == Op::ConstFloat && e.float_value < 0);
        return {text_of(code_, Value{.type = e.type, .int_value = e.int_value, .float_value = e.float_value}),
                negative ? Precedence::Unary : Precedence::Primary};
      }
      case Op::LoadSelf: return {names_.self[e.index]};
      case Op::LoadBind: return {names_.bind[e.index]};
      case Op::Call: return {call(e)};
      case Op::IntToFloat:
        return expr(e.a);
        BIP_SIGN_OPS(BIP_OP_CASE)
        return print_unary(Dialect::Bip, e.op, expr(e.a));
        BIP_BINARY_OPS(BIP_OP_CASE) {
          ExprText left = expr(e.a);
          return print_binary(Dialect::Bip, e.op, std::move(left), expr(e.b));
        }
    }
    BIP_UNREACHABLE("operator");
  }

  void stmts(StmtId first) {
    const std::size_t begin = out_.size();
    for (StmtId id = first; id.is_valid(); id = code_.stmts[id].next) {
      if (is_hidden(code_.stmts[id])) continue;
      if (out_.size() > begin) out_ += ' ';
      stmt(code_.stmts[id]);
    }
  }

  std::string take() { return std::move(out_); }

 private:
  // Hidden variables have no name.
  [[nodiscard]] bool is_hidden(const Stmt& s) const {
    const std::optional<std::uint32_t> self = model::assigned_variable(s, Op::LoadSelf);
    const std::optional<std::uint32_t> bind = model::assigned_variable(s, Op::LoadBind);
    return (self && names_.self[*self].empty()) || (bind && names_.bind[*bind].empty());
  }
  void stmt(const Stmt& s) {
    const std::string value = expr(s.value).text;
    switch (shape_of(s)) {
      case StmtShape::StoresSelf: out_ += names_.self[s.index] + " = " + value + ';'; break;
      case StmtShape::StoresBind: out_ += names_.bind[s.index] + " = " + value + ';'; break;
      case StmtShape::Evaluates: out_ += info_of(s.op).before + value + ';'; break;
      case StmtShape::Chooses: choice(s, value); break;
    }
  }
  void choice(const Stmt& s, const std::string& condition) {
    out_ += info_of(s.op).before + ("(" + condition + ") then ");
    stmts(s.then_body);
    if (s.else_body.is_valid()) {
      out_ += " else ";
      stmts(s.else_body);
    }
    out_ += " fi";
  }
  std::string call(const Expr& e) {
    const Function& function = code_.functions[e.index];
    // The generator of a draw has no name in the model.
    const std::span<const ExprId> args = code_.args_of(e).subspan(function.kind == FunctionKind::Draw ? 1 : 0);
    // Signs of FFI operators have no precedence of their own here: they get parentheses.
    const bool is_sign = function.kind == FunctionKind::Operator;
    std::string out = is_sign ? "(" : function.kind == FunctionKind::Cast ? "" : function.name + "(";
    if (is_sign && args.size() == 1) out += function.name;
    for (std::size_t k = 0; k < args.size(); ++k) {
      if (k > 0) out += is_sign ? " " + function.name + " " : ", ";
      out += at_least(expr(args[k]), is_sign ? Precedence::Unary : Precedence::Loosest);
    }
    return out + (function.kind == FunctionKind::Cast ? "" : ")");
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
    if (model::assigned_variable(code.stmts[id], Op::LoadSelf) == variable) return code.stmts[id].value;
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
  return CodeTextWriter(code, names).expr(expr).text;
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
    case Type::Float: break;
  }
  return float_text(value.float_value);
}

std::string condition_of(const CodeTable& code, const AtomType& type, ExprId guard, const TimeGuard& when) {
  const CodeNames names = names_of(type);
  std::string out;
  if (guard.is_valid()) {
    out =
        at_least(CodeTextWriter(code, names).expr(guard), when.bounds.empty() ? Precedence::Loosest : Precedence::And);
  }
  for (const Bound& bound : when.bounds) {
    if (!out.empty()) out += " && ";
    const Clock& clock = type.clocks[bound.clock];
    out += clock.name;
    if (bound.minus != Bound::kNone) out += " - " + type.clocks[bound.minus].name;
    out += sign_of(bound.op);
    const ExprId limit = bound.variable == Bound::kNone ? ExprId() : limit_of(code, when.measure, bound.variable);
    if (limit.is_valid()) {
      out += at_least(CodeTextWriter(code, names).expr(limit), Precedence::Sum);
    } else if (bound.variable != Bound::kNone) {
      out += type.variables[bound.variable].name;
    } else {
      out += fmt::format("{}", static_cast<double>(bound.ticks) / static_cast<double>(clock.unit));
    }
  }
  return out;
}

std::string in_brackets(const std::string& text) { return text.empty() ? "" : "[" + text + "]"; }

std::string resume_text(const CodeTable& code, const AtomType& type, const Resume& resume) {
  return resume.present ? "resume " + in_brackets(condition_of(code, type, resume.guard, resume.when)) : "";
}

AtomTypeHeading heading_of(const CodeTable& code, const AtomType& type) {
  std::string params, data, clocks;
  for (std::size_t k = 0; k < type.visible_variables(); ++k) {
    const DataVariable& variable = type.variables[k];
    std::string& list = variable.is_param ? params : data;
    list += (list.empty() ? "" : ", ") + code.type_name(variable.type) + " " + variable.name;
  }
  for (const Clock& clock : type.clocks) clocks += (clocks.empty() ? "clock " : ", ") + clock.name;
  AtomTypeHeading heading{type.name + "(" + params + ")", {data, clocks}};
  const CodeNames names = names_of(type);
  for (const AtomPriority& rule : type.priorities) {
    const auto side = [&type](std::uint32_t port) {
      return port == AtomPriority::kAnyPort ? std::string("*") : type.ports[port].name;
    };
    heading.lines.push_back("priority " + side(rule.low) + " < " + side(rule.high) + " " +
                            in_brackets(text_of(code, rule.guard, names)));
  }
  for (const Invariant& invariant : type.invariants) {
    const std::string where = list_of(invariant.places, type.places);
    const std::string scope = invariant.scope == InvariantScope::Always ? ""
                              : invariant.scope == InvariantScope::At   ? "at " + where + " "
                                                                        : "from " + where + " ";
    heading.lines.push_back("invariant " + scope +
                            in_brackets(condition_of(code, type, invariant.condition, invariant.when)));
  }
  return heading;
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
  BIP_ASSERT(open.empty(), "{} groups of `define` lack children", open.size());
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
