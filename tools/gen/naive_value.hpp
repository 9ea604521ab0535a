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
/// Wraps at 32 bits.
[[nodiscard]] Value of_int(std::int64_t wide);
[[nodiscard]] Value of_bool(bool truth);
[[nodiscard]] Value of_float(double f);
/// int to float if the target is float; what a Wide has beyond a Pair is lost.
[[nodiscard]] Value converted(Value value, Ty type);

/// Where a name's value lives.
using Lookup = std::function<Value&(const std::string& scope, const std::string& name)>;

/// Where code stands, and what came of it.
struct Place {
  bool is_const = false;  // guards, `up`, invariants: nothing may change, `const_f` is called where there is one
  std::uint64_t* generator = nullptr;  // of the atom whose action it is
  bool fault = false;  // division by zero, INT_MIN / -1, an exception; what is computed after that means nothing
};
[[nodiscard]] Value evaluate(const Expr& expr, const Lookup& lookup, Place& at);
/// Where the generator of an atom starts, by its number in the image.
[[nodiscard]] std::uint64_t first_of_generator(std::uint64_t seed, std::uint64_t atom);
/// A draw. Requires a generator.
[[nodiscard]] Value draw_value(const Expr& expr, const Lookup& lookup, Place& at);
/// Runs the statements up to the first fault.
void execute(const Body& body, const Lookup& lookup, Place& at);

}  // namespace bip::gen
