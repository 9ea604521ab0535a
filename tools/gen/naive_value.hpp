// Values and code of the naive oracle: LANGUAGE.md §3 evaluated over the description's expressions, by name.
#pragma once
#include <functional>
#include <map>

#include "tools/gen/description.hpp"

namespace bip::gen {

struct Value {
  Ty type = Ty::Int;
  std::int32_t i = 0;  // Int, Bool
  double f = 0;
  std::string s;
};
using Values = std::map<std::string, Value>;

[[nodiscard]] Value zero_of(Ty type);
/// int to float if the target is float.
[[nodiscard]] Value converted(Value value, Ty type);

/// Where a name's value lives.
using Lookup = std::function<Value&(const std::string& scope, const std::string& name)>;

/// Division by zero and INT_MIN / -1 set `fault`; what is computed after that means nothing.
[[nodiscard]] Value evaluate(const Expr& expr, const Lookup& lookup, bool& fault);
/// Runs the statements up to the first fault.
void execute(const Body& body, const Lookup& lookup, bool& fault);

}  // namespace bip::gen
