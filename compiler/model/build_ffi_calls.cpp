// Calls of C++ functions and operators as typed code. Part of CodeBuilder (code_builder.hpp).
//
// The prototype is chosen by the arguments' types (ffi_declarations.hpp). A row of CodeTable::functions says how C++ is
// called with exactly these types, so conversions along `refine` are left to C++, which knows the classes.
#include "compiler/model/draws.hpp"
#include "compiler/model/ffi_declarations.hpp"
#include "compiler/model/packages.hpp"

namespace bip::model {

namespace {

constexpr std::size_t kShownPrototypes = 8;

void list_prototypes(const Model& model, DiagnosticBuilder d, const std::vector<const syntax::Decl*>& prototypes) {
  for (std::size_t k = 0; k < prototypes.size() && k < kShownPrototypes; ++k) {
    d.label(prototypes[k]->range, fmt::format("`{}`", prototype_text(model, *prototypes[k])));
  }
  if (prototypes.size() > kShownPrototypes) d.note(fmt::format("and {} more", prototypes.size() - kShownPrototypes));
}

bool is_of_chance(const Model& model, const syntax::Decl& prototype) {
  return package_of(model, prototype.range.file).name == kChancePackage;
}

}  // namespace

std::optional<Argument> CodeBuilder::argument(const syntax::Expr* e) {
  const std::optional<Typed> typed = expr(e);
  if (!typed) return std::nullopt;
  if (e->kind != syntax::ExprKind::Path) return Argument{*typed, false, false, e->range};
  const Binding* b = find(e->path, Lookup::Silent);
  const bool is_variable = in_block_ && b != nullptr && b->read_only.empty() && !b->value.is_valid() && !b->poison;
  return Argument{*typed, is_variable, b == nullptr || b->is_constant, e->range};
}

std::optional<Argument> CodeBuilder::call_argument(const syntax::Expr* e) {
  const Binding* b = e->kind == syntax::ExprKind::Path ? find(e->path, Lookup::Silent) : nullptr;
  if (b != nullptr && b->is_clock && !e->clock_speed && in_block_) return clock_argument(e, *b);
  return argument(e);
}

Argument CodeBuilder::clock_argument(const syntax::Expr* e, const Binding& clock) {
  const auto variable = clock.index + static_cast<std::uint32_t>(ClockVariable::Value);
  const ExprId value =
      make({.op = Op::LoadSelf, .type = Type::Float, .index = variable, .a = {}, .b = {}, .loc = loc(e->range)});
  return {{value, Type::Float}, false, false, e->range, true};
}

std::vector<Argument> CodeBuilder::with_whole_clocks(const std::vector<Argument>& args) {
  std::vector<Argument> out = args;
  for (Argument& arg : out) {
    if (arg.is_clock) arg.typed.type = Type::Int;
  }
  return out;
}

std::optional<Typed> CodeBuilder::ffi_call(const std::string& name, const std::vector<const syntax::Decl*>& prototypes,
                                           std::vector<Argument> args, SourceRange at, CallUse use) {
  CodeTable& code = model_.code;
  std::vector<const syntax::Decl*> best = best_prototypes(model_, prototypes, args);
  if (best.empty()) best = best_prototypes(model_, prototypes, with_whole_clocks(args));
  if (best.size() != 1) {
    const bool is_operator = prototypes.front()->kind == syntax::DeclKind::ExternOperator;
    const std::string shown = is_operator ? std::string(prototypes.front()->op.text) : name;
    if (best.empty()) {
      auto d = diags_.report(Diag::kB1040, at, shown, types_text(code, args));
      list_prototypes(model_, d, prototypes);
      for (const Argument& arg : args) {
        if (is_ffi(arg.typed.type) && !arg.is_variable) {
          d.help("an object that may not change here needs a `const` parameter");
          break;
        }
      }
    } else {
      list_prototypes(model_, diags_.report(Diag::kB1041, at, shown, types_text(code, args), best.size()), best);
    }
    return std::nullopt;
  }
  const syntax::Decl& prototype = *best.front();
  Diagnostics quiet;
  Function row{
      .kind = prototype.kind == syntax::DeclKind::ExternOperator ? FunctionKind::Operator : FunctionKind::Function,
      .name = std::string(prototype.kind == syntax::DeclKind::ExternOperator ? prototype.op.text : prototype.name.text),
      .is_const = const_calls_,
      .has_result = prototype.result.is_written(),
      .result = prototype.result.is_written() ? data_type(model_, prototype.result, quiet) : Type::Int,
      .params = {},
      .loc = loc(prototype.range)};
  if (use == CallUse::Value && !row.has_result) {
    diags_.report(Diag::kB1043, at, row.name).label(prototype.range, "declared here without a type");
    return std::nullopt;
  }
  std::vector<ExprId> ids;
  for (std::size_t k = 0; k < args.size(); ++k) {
    const syntax::TypeRef& param = prototype.params[k].type;
    const Type wanted = data_type(model_, param, quiet);
    Typed value = args[k].typed;
    if (value.type == Type::Int && wanted == Type::Float) value = convert(value, Type::Float);
    if (args[k].is_clock) {
      if (wanted == Type::Int) value = cast(value, Type::Int);
      diags_.report(Diag::kB1616, args[k].range, row.name, model_.sources->text(args[k].range))
          .help("`explore` follows no such value; data that count steps or periods can be followed");
    }
    const bool can_refer =
        is_ffi(value.type) || ((value.type == Type::Int || value.type == Type::Float) && value.id == args[k].typed.id);
    if (args[k].is_constant && !param.is_const && !is_ffi(wanted)) {
      diags_.report(Diag::kB1052, args[k].range, model_.sources->text(args[k].range), row.name)
          .label(prototype.params[k].type.name.range, "this parameter is not `const`")
          .help("declare the parameter `const`, or give the function a variable");
    }
    row.params.push_back({value.type, args[k].is_variable && !param.is_const && can_refer});
    ids.push_back(value.id);
  }
  if (is_of_chance(model_, prototype)) {
    Function drawn = row;
    drawn.kind = FunctionKind::Draw;
    drawn.is_const = false;
    for (FunctionParam& param : drawn.params) param.by_reference = false;
    drawn.params.insert(drawn.params.begin(), {Type::Float, true});
    if (distribution_of(drawn) != nullptr) return draw(drawn, ids, at);
  }
  const auto first = static_cast<std::int32_t>(code.args.size());
  code.args.insert(code.args.end(), ids.begin(), ids.end());
  const Type result = row.result;
  const std::uint32_t function = function_row(code, std::move(row));
  return Typed{
      make({.op = Op::Call, .type = result, .index = function, .int_value = first, .a = {}, .b = {}, .loc = loc(at)}),
      result};
}

// The generator is a hidden variable of the atom, made for its first draw.
std::optional<Typed> CodeBuilder::draw(const Function& prototype, const std::vector<ExprId>& args, SourceRange at) {
  CodeTable& code = model_.code;
  if (scope_.drawing == nullptr || !may_draw_ || const_calls_) {
    diags_.report(Diag::kB1170, at, prototype.name).help("draw in an action into data, and read these here");
    return std::nullopt;
  }
  AtomType& atom = *scope_.drawing;
  if (atom.draws == AtomType::kNoDraws) {
    atom.draws = static_cast<std::uint32_t>(atom.variables.size());
    atom.variables.push_back({"random numbers", Type::Float, false, false, {}});
  }
  const ExprId generator =
      make({.op = Op::LoadSelf, .type = Type::Float, .index = atom.draws, .a = {}, .b = {}, .loc = loc(at)});
  const auto first = static_cast<std::int32_t>(code.args.size());
  code.args.push_back(generator);
  code.args.insert(code.args.end(), args.begin(), args.end());
  const std::uint32_t function = function_row(code, prototype);
  const ExprId id = make({.op = Op::Call,
                          .type = prototype.result,
                          .index = function,
                          .int_value = first,
                          .a = {},
                          .b = {},
                          .loc = loc(at)});
  if (const char* problem = constant_argument_problem(code, code.exprs[id]))
    diags_.report(Diag::kB1171, at, prototype.name, problem);
  return Typed{id, prototype.result};
}

std::optional<Typed> CodeBuilder::ffi_function(const syntax::Expr* e, const std::string& name,
                                               const std::vector<const syntax::Decl*>& prototypes) {
  const CallUse use = is_statement_ ? CallUse::Statement : CallUse::Value;
  is_statement_ = false;
  std::vector<Argument> args;
  bool sound = true;
  for (const syntax::Expr* operand : e->operands) {
    const std::optional<Argument> arg = call_argument(operand);
    sound = sound && arg.has_value();
    if (arg) args.push_back(*arg);
  }
  if (!sound) return std::nullopt;
  return ffi_call(name, prototypes, std::move(args), e->range, use);
}

std::optional<Typed> CodeBuilder::ffi_operator(const syntax::Expr* e, std::string_view sign, std::vector<Argument> args,
                                               bool& handled) {
  bool has_object = false, has_string = false;
  for (const Argument& arg : args) {
    has_object = has_object || is_ffi(arg.typed.type);
    has_string = has_string || arg.typed.type == Type::String;
  }
  const auto found = model_.operators.find("operator " + std::string(sign));
  handled = has_object;
  if (found == model_.operators.end()) {
    if (has_object)
      diags_.report(Diag::kB1042, e->op_range, sign, types_text(model_.code, args))
          .help(fmt::format("declare it: `extern operator const bool {}(…)`", sign));
    return std::nullopt;
  }
  // Native values keep their own meaning; strings may get one that BIP does not have.
  if (!has_object &&
      !(has_string && sign != "==" && sign != "!=" && !best_prototypes(model_, found->second, args).empty()))
    return std::nullopt;
  handled = true;
  return ffi_call(std::string(sign), found->second, std::move(args), e->op_range, CallUse::Value);
}

Typed CodeBuilder::cast(Typed v, Type to) {
  CodeTable& code = model_.code;
  const std::uint32_t function =
      function_row(code, {.kind = FunctionKind::Cast,
                          .name = code.type_name(to),
                          .is_const = false,
                          .has_result = true,
                          .result = to,
                          .params = {{v.type, false}},
                          .loc = is_ffi(v.type) ? code.ffi_types[ffi_row(v.type)].loc : code.exprs[v.id].loc});
  const auto first = static_cast<std::int32_t>(code.args.size());
  code.args.push_back(v.id);
  return {make({.op = Op::Call,
                .type = to,
                .index = function,
                .int_value = first,
                .a = {},
                .b = {},
                .loc = code.exprs[v.id].loc}),
          to};
}

}  // namespace bip::model
