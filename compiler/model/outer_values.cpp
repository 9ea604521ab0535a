// Parameters of a compound and variables of loops in the code of its inline connectors and priorities. That code is
// shared by all elements and runs long after they were made; where it names such a value it is built once for each
// value instead.
#include "compiler/model/compound_builder.hpp"

namespace bip::model {

std::optional<OuterValue> outer_value(const Scope& scope, const syntax::Path& path) {
  if (path.parts.size() != 1 || path.parts[0].index != nullptr || path.parts[0].star) return std::nullopt;
  const auto known = scope.names.find(std::string(path.parts[0].name.text));
  if (known == scope.names.end() || known->second.load != Op::LoadSelf || known->second.poison) return std::nullopt;
  return OuterValue{known->first, known->second.index, known->second.type};
}

OuterBindings outer_bindings(CodeTable& code, std::span<const OuterValue> values, const std::vector<Value>* self) {
  OuterBindings bindings;
  for (const OuterValue& v : values) {
    Expr e{.type = v.type};
    e.op = v.type == Type::Bool     ? Op::ConstBool
           : v.type == Type::Float  ? Op::ConstFloat
           : v.type == Type::String ? Op::ConstString
                                    : Op::ConstInt;
    if (self != nullptr) {
      e.int_value = (*self)[v.variable].int_value;
      e.float_value = (*self)[v.variable].float_value;
    } else {
      e.int_value = v.type == Type::String ? static_cast<std::int32_t>(code.string("")) : 1;
      e.float_value = 1;
    }
    bindings[v.name] = {
        .type = v.type, .read_only = "it keeps its value", .value = code.exprs.push(std::move(e)), .declared = {}};
  }
  return bindings;
}

ExprId priority_guard(Model& model, Diagnostics& diags, const PriorityRule& rule, const std::vector<Value>& self) {
  Scope scope{.names = outer_bindings(model.code, rule.values, &self),
              .owner = fmt::format("priority `{}`", rule.name)};
  for (std::uint32_t k = 0; k < rule.data.size(); ++k) {
    scope.names[rule.data_names[k]] = {.load = Op::LoadBind,
                                       .index = k,
                                       .type = rule.data[k].type,
                                       .read_only = "a guard",
                                       .value = {},
                                       .declared = {}};
  }
  return CodeBuilder(model, diags, scope).guard(rule.guard_syntax);
}

}  // namespace bip::model
