// The functions that the code of a random model may call, as data: what the generator needs to write a call, and the
// oracle to evaluate it. The C++ code is tools/gen/ffi/random_ffi.hpp and the C and C++ libraries.
#pragma once
#include "tools/gen/naive_value.hpp"

namespace bip::gen {

struct FfiParam {
  Ty type = Ty::Int;
  bool by_reference = false;
};
struct FfiPrototype {
  const char* name;       // an operator: its sign
  const char* prototype;  // as declared, without `extern`
  bool has_result = true;
  Ty result = Ty::Int;
  std::vector<FfiParam> params;
  bool is_operator = false;
  bool is_library = false;  // of the C or C++ library: no @cpp
  bool may_fault = false;
  /// `is_const`: the call stands where nothing may change. False: an exception.
  bool (*apply)(const std::vector<Value*>& args, bool is_const, Value& result);

  /// Changes nothing: may stand in any expression.
  [[nodiscard]] bool is_pure() const;
};

/// All of them; Expr::row and Stmt's call are rows of it.
[[nodiscard]] const std::vector<FfiPrototype>& ffi_functions();

/// `name` of functions with a `const_name`.
[[nodiscard]] bool has_const_variant(const std::string& name);

}  // namespace bip::gen
