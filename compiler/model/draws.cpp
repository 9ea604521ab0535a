// See draws.hpp.
#include "compiler/model/draws.hpp"

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "compiler/model/evaluate.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::model {

namespace {

char letter_of(Type type) {
  switch (type) {
    case Type::Int: return 'i';
    case Type::Float: return 'f';
    case Type::Bool: return 'b';
    case Type::String: break;
  }
  return '?';
}

// The value of an argument that reads no variable.
std::optional<double> constant_of(const CodeTable& code, ExprId id) {
  const Expr& e = code.exprs[id];
  if (e.op == Op::LoadSelf || e.op == Op::LoadBind || e.op == Op::Call) return std::nullopt;
  for (const ExprId operand : {e.a, e.b}) {
    if (operand.is_valid() && !constant_of(code, operand)) return std::nullopt;
  }
  const Evaluated found = evaluate(code, id, {});
  if (found.fault != Fault::None) return std::nullopt;
  return found.value.type == Type::Float ? found.value.float_value : found.value.int_value;
}

struct Arguments {
  const rt::ProbabilityDistribution* distribution = nullptr;
  std::array<double, rt::kMostDrawArguments> numbers{};  // 0: no constant
  bool are_constant = true, are_floats_constant = true;
};
Arguments arguments_of(const CodeTable& code, const Expr& draw) {
  Arguments found;
  found.distribution = distribution_of(code.functions[draw.index]);
  BIP_ASSERT(draw.op == Op::Call && found.distribution != nullptr, "expression {} is no draw", draw.op);
  const std::span<const ExprId> args = code.args_of(draw).subspan(1);
  for (std::size_t k = 0; k < args.size(); ++k) {
    const std::optional<double> value = constant_of(code, args[k]);
    found.numbers[k] = value.value_or(0);
    if (value) continue;
    found.are_constant = false;
    if (code.exprs[args[k]].type == Type::Float) found.are_floats_constant = false;
  }
  return found;
}

}  // namespace

const rt::ProbabilityDistribution* distribution_of(const Function& function) {
  if (function.kind != FunctionKind::Draw || !function.has_result || function.params.empty()) return nullptr;
  const FunctionParam& generator = function.params.front();
  if (!generator.by_reference || generator.type != Type::Float) return nullptr;
  std::string params;
  for (std::size_t k = 1; k < function.params.size(); ++k) {
    if (function.params[k].by_reference) return nullptr;
    params += letter_of(function.params[k].type);
  }
  return rt::find_distribution(function.name, params, letter_of(function.result));
}

const char* constant_argument_problem(const CodeTable& code, const Expr& draw) {
  const Arguments given = arguments_of(code, draw);
  return given.are_constant ? rt::argument_problem(*given.distribution, given.numbers.data()) : nullptr;
}

bool has_good_constants(const CodeTable& code, const Expr& draw) {
  const Arguments given = arguments_of(code, draw);
  // Which values a table has makes no difference.
  const bool is_known =
      given.are_constant || (given.are_floats_constant && given.distribution->name == std::string_view("table"));
  return is_known && rt::argument_problem(*given.distribution, given.numbers.data()) == nullptr;
}

}  // namespace bip::model
