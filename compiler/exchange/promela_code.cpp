// See promela_code.hpp. Recursion follows the nesting of code, which .bsys limits.
#include "compiler/exchange/promela_code.hpp"

#include <charconv>
#include <limits>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "compiler/model/print_expr.hpp"
#include "compiler/model/statements.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::exchange {

namespace {

// A guard that reads an `up` has its text in it; what grows beyond this is refused.
constexpr std::size_t kMaxText = 100000;

std::string number(std::int32_t value) {
  if (value == std::numeric_limits<std::int32_t>::min()) return "(-2147483647 - 1)";
  return value < 0 ? fmt::format("({})", value) : fmt::format("{}", value);
}

// Returns what `number` has written; nothing: it is another text.
std::optional<std::int32_t> value_of(std::string_view text) {
  if (text.starts_with("(-") && text.ends_with(')')) text = text.substr(1, text.size() - 2);
  std::int32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

}  // namespace

void PromelaCode::refuse(const std::string& what, const Loc& loc) {
  if (!refusal_.empty()) return;
  refusal_ = what;
  if (loc.line != 0 && loc.file < system_.files.size())
    refusal_ += fmt::format(" ({}:{}:{})", system_.files[loc.file], loc.line, loc.column);
}

// A float that is stored and never compared: reading one is refused, so that what is left out changes nothing.
bool PromelaCode::decides_nothing(const Stmt& store) {
  if (is_ffi(store.type) || (store.type == Type::Float && code_.has_cpp()))
    refuse("data of type " + code_.type_name(store.type), store.loc);
  return store.type == Type::Float;
}

std::string PromelaCode::division(const Expr& e, const std::string& a, const Names& names) {
  const std::string divisor = text(e.b, names);
  // By anything else it may be a run-time error in the middle of an expression. The text of a parameter is its value.
  const std::optional<std::int32_t> value = value_of(divisor);
  if (!value || *value == 0 || *value == -1) refuse("a division by what is no constant, or by 0 or -1", e.loc);
  return print_binary(Dialect::Promela, e.op, {a}, {divisor}).text;
}

std::string PromelaCode::text(ExprId expr, const Names& names) {
  if (!expr.is_valid()) return "true";
  const Expr& e = code_.exprs[expr];
  switch (e.op) {
    case Op::ConstInt:
    case Op::ConstString: return number(e.int_value);
    case Op::ConstBool: return e.int_value != 0 ? "true" : "false";
    case Op::LoadSelf:
    case Op::LoadBind: {
      const std::string name = e.op == Op::LoadSelf ? names.self(e.index) : names.bind(e.index);
      if (e.type == Type::Float || is_ffi(e.type)) refuse("data of type " + code_.type_name(e.type), e.loc);
      if (name.empty()) refuse("what is read of a merged port that does not take part", e.loc);
      return name;
    }
    case Op::ConstFloat:
    case Op::IntToFloat: refuse("data of type float", e.loc); return "0";
    case Op::Call:
      refuse(code_.functions[e.index].kind == FunctionKind::Draw ? "a random number" : "a call of C++", e.loc);
      return "0";
      BIP_SIGN_OPS(BIP_OP_CASE)
      BIP_BINARY_OPS(BIP_OP_CASE)
      break;
  }
  if (info_of(e.op).promela == nullptr) {
    refuse(fmt::format("`{}`, which Promela lacks", symbol_of(e.op)), e.loc);
    return "0";
  }
  const std::string a = text(e.a, names);
  if (family_of(e.op) == OpFamily::Sign) return print_unary(Dialect::Promela, e.op, {a}).text;
  if (is_division(e.op)) return division(e, a, names);
  std::string all = print_binary(Dialect::Promela, e.op, {a}, {text(e.b, names)}).text;
  if (all.size() > kMaxText) refuse("an expression that becomes too long", e.loc);
  return refusal_.empty() ? all : "0";
}

std::string PromelaCode::statements(StmtId body, const Names& names, const std::string& indent) {
  std::string out;
  for (StmtId row = body; row.is_valid(); row = code_.stmts[row].next) {
    const Stmt& s = code_.stmts[row];
    switch (shape_of(s)) {
      case StmtShape::StoresSelf: out += assignment(s, names.self, names, indent); break;
      case StmtShape::StoresBind: out += assignment(s, names.bind, names, indent); break;
      case StmtShape::Chooses: {
        const auto branch = [&](StmtId inner) {
          return inner.is_valid() ? statements(inner, names, indent + "  ") : indent + "  skip;\n";
        };
        out += fmt::format("{0}if\n{0}:: {1} ->\n{2}{0}:: else ->\n{3}{0}fi;\n", indent, text(s.value, names),
                           branch(s.then_body), branch(s.else_body));
        break;
      }
      case StmtShape::Evaluates: refuse_evaluation(s, names); break;
    }
  }
  return out;
}

// For the sake of what it does besides: a call refuses itself.
void PromelaCode::refuse_evaluation(const Stmt& s, const Names& names) {
  (void)text(s.value, names);
  refuse(fmt::format("a statement `{}`", info_of(s.op).word), s.loc);
}

std::string PromelaCode::assignment(const Stmt& s, const NameOf& target, const Names& names,
                                    const std::string& indent) {
  if (decides_nothing(s)) return "";
  const std::string name = target(s.index);
  if (name.empty()) refuse("what is written to a merged port that does not take part", s.loc);
  return fmt::format("{}{} = {};\n", indent, name, text(s.value, names));
}

void PromelaCode::substitute(StmtId body, const Names& names, std::map<u32, std::string>& self) {
  Names current = names;
  current.self = [&self](u32 k) { return self.at(k); };
  for (StmtId row = body; row.is_valid() && refusal_.empty(); row = code_.stmts[row].next) {
    const Stmt& s = code_.stmts[row];
    switch (shape_of(s)) {
      case StmtShape::StoresSelf:
        if (!decides_nothing(s)) self[s.index] = text(s.value, current);
        break;
      case StmtShape::Chooses: {
        const std::string condition = text(s.value, current);
        std::map<u32, std::string> yes = self, no = self;
        substitute(s.then_body, names, yes);
        substitute(s.else_body, names, no);
        for (auto& [variable, value] : self)
          value = yes[variable] == no[variable]
                      ? yes[variable]
                      : fmt::format("({} -> {} : {})", condition, yes[variable], no[variable]);
        break;
      }
      case StmtShape::StoresBind: BIP_UNREACHABLE("an `up` that stores into a port");
      case StmtShape::Evaluates: refuse_evaluation(s, current); break;
    }
  }
}

}  // namespace bip::exchange
