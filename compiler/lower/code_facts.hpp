// Static facts about the code of a unit: can it fault, does it call C++.
#pragma once
#include <cstdint>
#include <vector>

#include "compiler/model/code.hpp"

namespace bip::lower {

struct CodeFacts {
  bool may_fault = false;  // it calls C++, or divides by what may be 0 or -1
  bool calls = false;      // C++
  bool writes_binds = false;
  std::vector<ExprId> divisors;      // of divisions of ints, but for constants other than 0 and -1
  std::vector<std::uint32_t> binds;  // bound variables that it reads or writes, ascending
};
/// Of an expression, or of statements; either may be invalid. Linear in the code, iterative.
[[nodiscard]] CodeFacts code_facts(const CodeTable& code, ExprId expr, StmtId body);

}  // namespace bip::lower
