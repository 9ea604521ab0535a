// The small pieces of .bsys text and the code IR in nested prefix form.
//
// Iterative: a stack of what is still to be written, so that deep trees cost heap, not stack. Needs a System that
// `validate` accepts. Linear in the output.
#include "compiler/system/print_bsys_code.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "compiler/model/statements.hpp"

namespace bip::system::text {
namespace {

/// Something still to be written.
struct Item {
  enum class Kind : std::uint8_t { Text, Expr, Stmts, Close } kind = Kind::Text;
  std::uint32_t row = 0;       // Expr, Stmts
  const char* text = nullptr;  // Text
  Loc loc{};                   // Close: the place, then the parenthesis
};

class CodePrinter {
 public:
  CodePrinter(std::string& out, const CodeTable& code, const CodeScope& scope)
      : out_(out), code_(code), scope_(scope) {}

  void run(const Item& first) {
    stack_.push_back(first);
    while (!stack_.empty()) {
      const Item item = stack_.back();
      stack_.pop_back();
      switch (item.kind) {
        case Item::Kind::Text: out_ += item.text; break;
        case Item::Kind::Expr: expr(code_.exprs[ExprId(item.row)]); break;
        case Item::Kind::Stmts: stmt(code_.stmts[StmtId(item.row)]); break;
        case Item::Kind::Close:
          put_loc(out_, item.loc);
          out_ += ')';
          break;
      }
    }
  }

 private:
  // What is pushed last is written first.
  void push_text(const char* text) { stack_.push_back({.kind = Item::Kind::Text, .text = text}); }
  void push_expr(ExprId id) { stack_.push_back({.kind = Item::Kind::Expr, .row = id.value}); }
  void push_close(const Loc& loc) { stack_.push_back({.kind = Item::Kind::Close, .loc = loc}); }
  void push_stmts(StmtId id) {
    if (id.is_valid()) stack_.push_back({.kind = Item::Kind::Stmts, .row = id.value});
  }
  void variable(const std::vector<ScopeVariable>& variables, std::uint32_t index) {
    put_ref(out_, index, index < variables.size() ? std::string_view(variables[index].name) : std::string_view());
  }

  void expr(const Expr& e) {
    switch (e.op) {
      case Op::ConstInt:
      case Op::ConstBool:
      case Op::ConstFloat:
      case Op::ConstString:
        put_literal(out_, {.type = e.type, .int_value = e.int_value, .float_value = e.float_value}, code_);
        return;
      case Op::LoadSelf:
      case Op::LoadBind:
        out_ += e.op == Op::LoadSelf ? "(self " : "(bind ";
        variable(e.op == Op::LoadSelf ? scope_.self : scope_.bind, e.index);
        out_ += ')';
        return;
      case Op::Call: {
        out_ += "(call ";
        put_ref(out_, e.index, code_.functions[e.index].name);
        push_close(e.loc);
        const std::span<const ExprId> args = code_.args_of(e);
        for (std::size_t k = args.size(); k-- > 0;) {
          push_expr(args[k]);
          push_text(" ");
        }
        return;
      }
        BIP_UNARY_OPS(BIP_OP_CASE)
        BIP_BINARY_OPS(BIP_OP_CASE)
        break;
    }
    out_ += '(';
    out_ += info_of(e.op).word;
    out_ += ' ';
    // Only divisions and calls can fault, so only they need their places.
    push_close(is_division(e.op) ? e.loc : Loc{});
    if (operand_count(e.op) == 2) {
      push_expr(e.b);
      push_text(" ");
    }
    push_expr(e.a);
  }

  void stmt(const Stmt& s) {
    push_stmts(s.next);
    push_close(s.loc);
    out_ += " (";
    out_ += info_of(s.op).word;
    out_ += ' ';
    switch (shape_of(s)) {
      case StmtShape::StoresSelf: target(scope_.self, s.index); break;
      case StmtShape::StoresBind: target(scope_.bind, s.index); break;
      case StmtShape::Chooses: branches(s); break;
      case StmtShape::Evaluates: break;
    }
    push_expr(s.value);
  }
  void target(const std::vector<ScopeVariable>& variables, std::uint32_t index) {
    variable(variables, index);
    out_ += ' ';
  }
  void branches(const Stmt& s) {
    if (s.else_body.is_valid()) {
      push_text(")");
      push_stmts(s.else_body);
      push_text(" (else");
    }
    push_text(")");
    push_stmts(s.then_body);
    push_text(" (then");
  }

  std::string& out_;
  const CodeTable& code_;
  const CodeScope& scope_;
  std::vector<Item> stack_;
};

}  // namespace

void put_quoted(std::string& out, std::string_view text) {
  out += '"';
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (c == '\n') {
      out += "\\n";
    } else if (c == '\t') {
      out += "\\t";
    } else if (byte < 0x20 || byte >= 0x7f) {
      fmt::format_to(std::back_inserter(out), "\\x{:02x}", byte);
    } else {
      out += c;
    }
  }
  out += '"';
}

void put_name(std::string& out, std::string_view name) {
  if (is_bare(name)) {
    out += name;
  } else {
    put_quoted(out, name);
  }
}

void put_number(std::string& out, std::uint64_t number) {
  const fmt::format_int digits(number);
  out.append(digits.data(), digits.size());
}

void put_ref(std::string& out, std::uint32_t row, std::string_view name) {
  put_number(out, row);
  if (!is_bare(name)) return;
  out += ':';
  out += name;
}

void put_loc(std::string& out, const Loc& loc) {
  if (loc.line == 0) return;
  out += " @";
  put_number(out, loc.file);
  out += ':';
  put_number(out, loc.line);
  out += ':';
  put_number(out, loc.column);
}

void put_literal(std::string& out, const Value& value, const CodeTable& code) {
  switch (value.type) {
    case Type::Int: fmt::format_to(std::back_inserter(out), "{}", value.int_value); return;
    case Type::Bool: out += value.int_value != 0 ? "true" : "false"; return;
    case Type::String: put_quoted(out, code.strings[static_cast<std::size_t>(value.int_value)]); return;
    case Type::Float: break;
  }
  // The payload of a NaN is invisible to models: every NaN is written alike.
  if (std::isnan(value.float_value)) {
    out += "nan";
    return;
  }
  const std::string digits = fmt::format("{}", value.float_value);
  out += digits;
  if (digits.find_first_not_of("-0123456789") == std::string::npos) out += ".0";
}

void put_expr(std::string& out, const CodeTable& code, ExprId expr, const CodeScope& scope) {
  CodePrinter(out, code, scope).run({.kind = Item::Kind::Expr, .row = expr.value});
}

void put_stmts(std::string& out, const CodeTable& code, StmtId first, const CodeScope& scope) {
  if (first.is_valid()) CodePrinter(out, code, scope).run({.kind = Item::Kind::Stmts, .row = first.value});
}

void put_when(std::string& out, const CodeTable& code, const AtomType& type, const TimeGuard& when,
              const CodeScope& scope) {
  for (const Bound& bound : when.bounds) {
    fmt::format_to(std::back_inserter(out), " (bound {} ", name_of(bound.op));
    put_ref(out, bound.clock, type.clocks[bound.clock].name);
    if (bound.minus != Bound::kNone) {
      out += " (minus ";
      put_ref(out, bound.minus, type.clocks[bound.minus].name);
      out += ')';
    }
    if (bound.variable == Bound::kNone) {
      fmt::format_to(std::back_inserter(out), " {}ns", bound.ticks);
    } else {
      out += " (slot ";
      put_ref(out, bound.variable, type.variables[bound.variable].name);
      out += ')';
    }
    put_loc(out, bound.loc);
    out += ')';
  }
  if (!when.measure.is_valid()) return;
  out += " (measure";
  put_stmts(out, code, when.measure, scope);
  out += ')';
}

void put_resume(std::string& out, const CodeTable& code, const AtomType& type, const Resume& resume,
                const CodeScope& scope) {
  if (!resume.present) return;
  out += " (resume";
  if (resume.guard.is_valid()) {
    out += " (guard ";
    put_expr(out, code, resume.guard, scope);
    out += ')';
  }
  put_when(out, code, type, resume.when, scope);
  put_loc(out, resume.loc);
  out += ')';
}

}  // namespace bip::system::text
