// Values and code of the naive oracle: compiler/docs/language_meaning.md, section 1, evaluated over the description's
// expressions, by name.
#pragma once
#include <functional>
#include <map>

#include "tools/gen/description.hpp"
#include "tools/gen/ffi/random_ffi.hpp"

namespace bip::gen {

struct Value {
  Ty type = Ty::Int;
  std::int32_t i = 0;  // Int, Bool
  double f = 0;
  std::string s;
  Wide w;  // Pair (c is 0), Wide
};
using Values = std::map<std::string, Value>;

[[nodiscard]] Value zero_of(Ty type);
/// int to float if the target is float; what a Wide has beyond a Pair is lost.
[[nodiscard]] Value converted(Value value, Ty type);

/// Where a name's value lives.
using Lookup = std::function<Value&(const std::string& scope, const std::string& name)>;

/// Where code stands, and what came of it.
struct Place {
  bool is_const = false;  // guards, `up`, invariants: nothing may change, `const_f` is called where there is one
  bool fault = false;     // division by zero, INT_MIN / -1, an exception; what is computed after that means nothing
};
[[nodiscard]] Value evaluate(const Expr& expr, const Lookup& lookup, Place& at);
/// Runs the statements up to the first fault.
void execute(const Body& body, const Lookup& lookup, Place& at);

}  // namespace bip::gen
