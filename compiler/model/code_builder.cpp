// Typed code from expressions. See code_builder.hpp for the promises.
#include "compiler/model/code_builder.hpp"

#include <algorithm>
#include <charconv>
#include <utility>

#include "compiler/model/ffi_declarations.hpp"
#include "compiler/model/operators.hpp"
#include "compiler/model/packages.hpp"
#include "compiler/model/suggest.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::model {

using syntax::BinaryOp;
using syntax::ExprKind;
using syntax::UnaryOp;

namespace {

Op op_of(BinaryOp op) {
  switch (op) {
#define BIP_OP_OF(name, ...) \
  case BinaryOp::name: return Op::name;
    BIP_BINARY_OPS(BIP_OP_OF)
#undef BIP_OP_OF
  }
  BIP_UNREACHABLE("binary operator");
}

const char* text_of(BinaryOp op) { return symbol_of(op_of(op)); }

/// What an operator wants, for messages.
const char* text_of(OperandTypes operands) {
  switch (operands) {
    case OperandTypes::Int: return "int";
    case OperandTypes::Bool: return "bool";
    case OperandTypes::Number: return "numbers";
    case OperandTypes::None:
    case OperandTypes::Native: break;
  }
  BIP_UNREACHABLE("operands");
}

// A chain of calls is unfolded by recursion, and each call may double the code or deepen it by its argument.
constexpr int kMaxCalls = 16;
constexpr std::size_t kMaxUnfolded = 100'000;
constexpr std::uint32_t kMaxUnfoldedDepth = 1000;
// After this many errors no similar names are looked for: comparing takes time.
constexpr std::size_t kHelpedErrors = 200;

}  // namespace

std::string path_key(const syntax::Path& path, const SourceMap& sources) {
  std::string key;
  for (const syntax::PathPart& part : path.parts) {
    if (!key.empty()) key += '.';
    key += part.name.text;
    if (part.star) key += "[*]";
    if (part.index != nullptr) {
      key += '[';
      for (const char c : sources.text(part.index->range)) {
        if (c != ' ' && c != '\t' && c != '\n' && c != '\r') key += c;
      }
      key += ']';
    }
  }
  return key;
}

std::string counted(std::size_t n, std::string_view what) { return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s"); }

std::optional<Type> native_type(const syntax::TypeRef& type, Diagnostics& diags) {
  if (type.name.parts.size() != 1) return std::nullopt;
  const std::string_view name = type.name.parts[0].name.text;
  if (name == "int") return Type::Int;
  if (name == "bool") return Type::Bool;
  if (name == "float") return Type::Float;
  if (name == "string") return Type::String;
  if (name == "double") {
    diags.report(Diag::kB1004, type.name.range).help("write `float`", type.name.range, "float");
    return Type::Float;
  }
  return std::nullopt;
}

ExprId CodeBuilder::poison(Type type) {
  Expr e{.type = type};
  e.op = type == Type::Bool     ? Op::ConstBool
         : type == Type::Float  ? Op::ConstFloat
         : type == Type::String ? Op::ConstString
                                : Op::ConstInt;
  if (type == Type::String) e.int_value = static_cast<std::int32_t>(model_.code.string(""));
  return make(e);
}

Typed CodeBuilder::convert(Typed v, Type to) {
  if (v.type == Type::Int && to == Type::Float) {
    return {make({.op = Op::IntToFloat, .type = Type::Float, .a = v.id, .b = {}, .loc = model_.code.exprs[v.id].loc}),
            Type::Float};
  }
  if (v.type != to && is_ffi(v.type) && refines(model_.code, v.type, to)) return cast(v, to);
  return v;
}

ExprId CodeBuilder::expr_as(const syntax::Expr* e, Type type, const std::string& what) {
  const std::optional<Typed> v = expr(e);
  if (!v) return poison(type);
  const Typed converted = convert(*v, type);
  if (converted.type != type) {
    auto d =
        diags_.report(Diag::kB1010, e->range, what, model_.code.type_name(type), model_.code.type_name(converted.type))
            .label(fmt::format("this is {}", model_.code.type_name(v->type)));
    help_wrong_type(d, *model_.sources, *e, type, v->type);
    return poison(type);
  }
  return converted.id;
}

std::optional<Typed> CodeBuilder::expr(const syntax::Expr* e) {
  switch (e->kind) {
    case ExprKind::Int:
    case ExprKind::Float:
    case ExprKind::Bool:
    case ExprKind::String:
    case ExprKind::Report: return literal(e);
    case ExprKind::Path: return path(e);
    case ExprKind::Unary: return unary(e);
    case ExprKind::Binary: return binary(e);
    case ExprKind::Call: return call(e);
  }
  return std::nullopt;
}

std::optional<Typed> CodeBuilder::literal(const syntax::Expr* e) {
  Expr out{.loc = loc(e->range)};
  switch (e->kind) {
    case ExprKind::Bool: out.op = Op::ConstBool, out.type = Type::Bool, out.int_value = e->truth ? 1 : 0; break;
    case ExprKind::Float: {
      out.op = Op::ConstFloat, out.type = Type::Float;
      const auto [end, error] = std::from_chars(e->text.data(), e->text.data() + e->text.size(), out.float_value);
      if (error == std::errc::result_out_of_range) {
        diags_.report(Diag::kB1012, e->range, e->text);
        return std::nullopt;
      }
      break;
    }
    case ExprKind::Int: {
      out.op = Op::ConstInt, out.type = Type::Int;
      const auto [end, error] = std::from_chars(e->text.data(), e->text.data() + e->text.size(), out.int_value);
      if (error != std::errc{}) {
        diags_.report(Diag::kB1011, e->range, e->text)
            .help("an `int` holds -2147483648 to 2147483647; a `float` is written with a point");
        return std::nullopt;
      }
      break;
    }
    case ExprKind::String:
    case ExprKind::Report:
    case ExprKind::Path:
    case ExprKind::Unary:
    case ExprKind::Binary:
    case ExprKind::Call:
      out.op = Op::ConstString, out.type = Type::String;
      out.int_value = static_cast<std::int32_t>(model_.code.string(std::string(e->text)));
      break;
  }
  const Type type = out.type;
  return Typed{make(out), type};
}

const Binding* CodeBuilder::find(const syntax::Path& p, Lookup lookup) {
  const std::string key = path_key(p, *model_.sources);
  if (const auto it = scope_.names.find(key); it != scope_.names.end()) return &it->second;
  if (lookup == Lookup::Silent) return nullptr;
  if (diags_.error_count() > kHelpedErrors) {
    diags_.report(Diag::kB1001, p.range, key, scope_.owner);
    return nullptr;
  }
  std::vector<std::string> known;
  for (const auto& [name, binding] : scope_.names) known.push_back(name);
  std::sort(known.begin(), known.end());
  auto d = diags_.report(Diag::kB1001, p.range, key, scope_.owner);
  if (p.parts.size() == 1) {  // in a connector: the variable without its port
    for (const std::string& name : known) {
      if (name.ends_with("." + key))
        return d.help(fmt::format("`{}` is a variable of a port", name), p.range, name), nullptr;
    }
  }
  const std::vector<std::string> similar = similar_names(key, known);
  for (const std::string& name : similar) d.help(fmt::format("`{}` has a similar name", name), p.range, name);
  if (similar.empty()) help_unknown_name(d, model_, p, key, known);
  return nullptr;
}

std::optional<Typed> CodeBuilder::path(const syntax::Expr* e) {
  const Binding* b = find(e->path, Lookup::Silent);
  if (e->clock_speed || (b != nullptr && b->is_clock)) return clock_path(e);
  if (b == nullptr) {
    const auto* constant =
        find_visible(model_, model_.constants, path_key(e->path, *model_.sources), e->path.range, diags_);
    if (constant != nullptr) return Typed{copy(constant->first), constant->second};
    find(e->path, Lookup::Reported);
    return std::nullopt;
  }
  if (b->poison) return std::nullopt;
  if (b->value.is_valid()) {
    // A parameter of a function. Each use but the first adds as much as the argument is large.
    if (std::exchange(b->is_fresh, false)) return Typed{b->value, b->type};
    if (model_.code.exprs.size() - unfold_start_ <= kMaxUnfolded) return Typed{copy(b->value), b->type};
    report_too_large(e);
    return std::nullopt;
  }
  BIP_ASSERT(b->load == Op::LoadSelf || b->load == Op::LoadBind, "a name stands for operation {}", b->load);
  return Typed{make({.op = b->load, .type = b->type, .index = b->index, .a = {}, .b = {}, .loc = loc(e->range)}),
               b->type};
}

std::optional<Typed> CodeBuilder::type_error(const syntax::Expr* e, const syntax::Expr* at, const char* wants, Type got,
                                             std::string_view help) {
  const std::string_view op =
      e->kind == ExprKind::Unary ? model_.sources->text(e->op_range) : std::string_view(text_of(e->binary));
  auto report = diags_.report(Diag::kB1013, at->range, op, wants, name_of(got));
  report.label(fmt::format("this is {}", name_of(got)));
  if (!help.empty()) report.help(std::string(help));
  const std::string text(model_.sources->text(at->range));
  const bool is_condition = got == Type::Bool && e->kind == ExprKind::Binary;
  if (is_condition && (op == "&" || op == "|")) {
    const std::string twice = std::string(op) + std::string(op);
    report.help(fmt::format("conditions are joined by `{}`", twice), e->op_range, twice);
  } else if (got == Type::Int && e->kind == ExprKind::Unary && op == "!") {
    report.help(fmt::format("write `{} == 0`", text), e->range, text + " == 0");
  } else if (got == Type::Int && (op == "&&" || op == "||") && at->kind == ExprKind::Path) {
    report.help(fmt::format("write `{} != 0`", text), at->range, text + " != 0");
  }
  return std::nullopt;
}

std::string CodeBuilder::operator_help(const syntax::Expr* e, const Typed& a, const Typed& b) const {
  if (a.type != Type::String && b.type != Type::String) return "";
  const bool is_sum = e->binary == BinaryOp::Add || e->binary == BinaryOp::Sub || e->binary == BinaryOp::Mul ||
                      e->binary == BinaryOp::Div || e->binary == BinaryOp::Mod;
  return fmt::format("C++ can define it: `extern operator const {} {} (const {}, const {})`",
                     is_sum ? "string" : "bool", text_of(e->binary), name_of(a.type), name_of(b.type));
}

std::optional<Typed> CodeBuilder::unary(const syntax::Expr* e) {
  const syntax::Expr* operand = e->operands[0];
  // -2147483648 is one number: its positive part alone would not fit.
  if (e->unary == UnaryOp::Neg && operand->kind == ExprKind::Int && operand->text == "2147483648") {
    return Typed{
        make({.op = Op::ConstInt, .type = Type::Int, .int_value = INT32_MIN, .a = {}, .b = {}, .loc = loc(e->range)}),
        Type::Int};
  }
  const std::optional<Argument> arg = argument(operand);
  if (!arg) return std::nullopt;
  const std::optional<Typed> v = arg->typed;
  bool handled = false;
  const std::optional<Typed> call = ffi_operator(e, model_.sources->text(e->op_range), {*arg}, handled);
  if (handled) return call;
  if (e->unary == UnaryOp::Plus) {
    if (!is_numeric(v->type)) return type_error(e, operand, "numbers", v->type);
    return v;
  }
  BIP_ASSERT(model_.code.exprs.contains(v->id) && model_.code.exprs[v->id].type == v->type,
             "expression {} has another type", v->id);
  const Op op = e->unary == UnaryOp::Neg ? Op::Neg : e->unary == UnaryOp::Not ? Op::Not : Op::BitNot;
  const OperandTypes operands = info_of(op).operands;
  if (!takes(operands, v->type)) return type_error(e, operand, text_of(operands), v->type);
  return Typed{make({.op = op, .type = v->type, .a = v->id, .b = {}, .loc = loc(e->range)}), v->type};
}

std::optional<Typed> CodeBuilder::binary(const syntax::Expr* e) {
  const std::optional<Argument> left = argument(e->operands[0]);
  const std::optional<Argument> right = argument(e->operands[1]);
  if (!left || !right) return std::nullopt;
  bool handled = false;
  const std::optional<Typed> call = ffi_operator(e, text_of(e->binary), {*left, *right}, handled);
  if (handled) return call;
  std::optional<Typed> a = left->typed;
  std::optional<Typed> b = right->typed;
  const Op op = op_of(e->binary);
  const OperandTypes operands = info_of(op).operands;
  if (operands == OperandTypes::Native) {
    if (a->type != b->type && !(is_numeric(a->type) && is_numeric(b->type))) {
      diags_.report(Diag::kB1014, e->op_range, text_of(e->binary), name_of(a->type), name_of(b->type))
          .label(e->operands[0]->range, fmt::format("this is {}", name_of(a->type)))
          .label(e->operands[1]->range, fmt::format("this is {}", name_of(b->type)));
      return std::nullopt;
    }
  } else {
    if (!takes(operands, a->type))
      return type_error(e, e->operands[0], text_of(operands), a->type, operator_help(e, *a, *b));
    if (!takes(operands, b->type))
      return type_error(e, e->operands[1], text_of(operands), b->type, operator_help(e, *a, *b));
  }
  const bool is_float = a->type == Type::Float || b->type == Type::Float;
  const Type result = result_of(op, is_float ? Type::Float : a->type);
  if (is_division(op) && result == Type::Int) warn_zero_divisor(e, *b);
  if (is_numeric(a->type) && a->type != b->type) {
    a = convert(*a, Type::Float);
    b = convert(*b, Type::Float);
  }
  BIP_ASSERT(a->type == b->type || is_ffi(a->type) || is_ffi(b->type), "operands of operator {} have types {} and {}",
             op, a->type, b->type);
  return Typed{make({.op = op, .type = result, .a = a->id, .b = b->id, .loc = loc(e->op_range)}), result};
}

bool CodeBuilder::may_inline(const syntax::Expr* e, const syntax::Decl& function) {
  int calls = 0;
  for (const CodeBuilder* up = this; up != nullptr && up->function_ != nullptr; up = up->caller_, ++calls) {
    if (up->function_ != &function) continue;
    diags_.report(Diag::kB1016, e->path.range, function.name.text).label(function.name.range, "declared here");
    return false;
  }
  if (calls > kMaxCalls) {
    // Bodies that double reach this point often.
    if (diags_.error_count() < kHelpedErrors)
      diags_.report(Diag::kB0008, e->path.range, kMaxCalls).label("functions call functions");
    return false;
  }
  if (model_.code.exprs.size() - unfold_start_ <= kMaxUnfolded) return true;
  report_too_large(e);
  return false;
}

void CodeBuilder::report_too_large(const syntax::Expr* e) {
  if (!diags_.has_errors())
    diags_.report(Diag::kB4006, e->path.range, kMaxUnfolded, "operations in one call").label("unfolded here");
}

// Size and depth of what a call became; the rows before it were counted when they were asked for.
bool CodeBuilder::is_small(ExprId unfolded, const syntax::Expr* e) {
  auto& shapes = model_.code_shapes;
  for (std::size_t row = shapes.size(); row < model_.code.exprs.size(); ++row) {  // operands come before their operator
    const Expr& expr = model_.code.exprs[ExprId(row)];
    CodeShape shape{1, 1};
    for (const ExprId operand : {expr.a, expr.b}) {
      if (!operand.is_valid()) continue;
      BIP_ASSERT(operand.value < row, "operand {} comes after its operator {}", operand, row);
      shape.size = std::min<std::size_t>(shape.size + shapes[operand.value].size, kMaxUnfolded + 1);
      shape.depth = std::max(shape.depth, shapes[operand.value].depth + 1);
    }
    if (expr.op == Op::Call) {
      for (const ExprId arg : model_.code.args_of(expr)) {
        shape.size = std::min<std::size_t>(shape.size + shapes[arg.value].size, kMaxUnfolded + 1);
        shape.depth = std::max(shape.depth, shapes[arg.value].depth + 1);
      }
    }
    shapes.push_back(shape);
  }
  BIP_ASSERT(shapes.size() == model_.code.exprs.size(), "{} shapes of {} expressions", shapes.size(),
             model_.code.exprs.size());
  const CodeShape& shape = shapes[unfolded.value];
  if (shape.depth > kMaxUnfoldedDepth) {
    if (!diags_.has_errors())
      diags_.report(Diag::kB0008, e->path.range, kMaxUnfoldedDepth).label("when this call is unfolded");
    return false;
  }
  if (shape.size <= kMaxUnfolded) return true;
  report_too_large(e);
  return false;
}

std::optional<Typed> CodeBuilder::call(const syntax::Expr* e) {
  const std::string name = path_key(e->path, *model_.sources);
  const auto* found = find_visible(model_, model_.functions, name, e->path.range, diags_);
  if (found == nullptr) {
    if (const auto prototypes = visible_prototypes(model_, name, e->path.range.file); !prototypes.empty())
      return ffi_function(e, name, prototypes);
    std::vector<std::string> known;
    if (diags_.error_count() <= kHelpedErrors) {
      for (const auto& [key, decls] : model_.prototypes) {
        if (std::string shown = shown_key(model_, key, e->path.range.file); !shown.empty())
          known.push_back(std::move(shown));
      }
      for (const auto& [key, decl] : model_.functions) {
        if (std::string shown = shown_key(model_, key, e->path.range.file); !shown.empty())
          known.push_back(std::move(shown));
      }
    }
    std::sort(known.begin(), known.end());
    auto d = diags_.report(Diag::kB1005, e->path.range, name);
    const std::vector<std::string> similar = similar_names(name, known);
    for (const std::string& s : similar) d.help(fmt::format("`{}` has a similar name", s), e->path.range, s);
    if (similar.empty())
      d.note("functions are declared: `extern function` for those of C++, `function int f(int x) = x + 1` for others");
    return std::nullopt;
  }
  const syntax::Decl& function = **found;
  is_statement_ = false;
  if (function.params.size() != e->operands.size()) {
    diags_
        .report(Diag::kB1015, e->range, counted(e->operands.size(), "argument"), fmt::format("function `{}`", name),
                function.params.size())
        .label(function.name.range, "declared here");
    return std::nullopt;
  }
  if (function_ == nullptr) unfold_start_ = model_.code.exprs.size();
  if (!may_inline(e, function)) return std::nullopt;
  BIP_ASSERT(unfold_start_ <= model_.code.exprs.size(), "code of calls begins at {} of {}", unfold_start_,
             model_.code.exprs.size());
  Scope inner{.names = {}, .owner = fmt::format("function `{}`", name)};
  for (std::size_t i = 0; i < function.params.size(); ++i) {
    Diagnostics quiet;  // the declaration itself was checked once
    const Type type = native_type(function.params[i].type, quiet).value_or(Type::Int);
    const ExprId arg = expr_as(e->operands[i], type, fmt::format("argument `{}`", function.params[i].name.text));
    inner.names[std::string(function.params[i].name.text)] = {.type = type,
                                                              .read_only = "a parameter keeps its value",
                                                              .value = arg,
                                                              .is_fresh = true,
                                                              .declared = function.params[i].name.range};
  }
  Diagnostics quiet;
  const Type result = native_type(function.result, quiet).value_or(Type::Int);
  CodeBuilder body(model_, diags_, inner, function, this);
  const ExprId value = body.expr_as(function.body, result, "the function's result");
  if (!is_small(value, e)) return std::nullopt;
  return Typed{value, result};
}

}  // namespace bip::model
