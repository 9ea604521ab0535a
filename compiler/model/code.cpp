// Names of the code IR's types and operators, and its string table.
//
// Row 0 of the string table is always "": variables start as zero bits, and that must read as the empty string.
// Interning scans the table: models have tens of string constants, not thousands.
#include "compiler/model/code.hpp"

#include <algorithm>

#include "compiler/model/operators.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip {

const char* name_of(Type type) {
  switch (type) {
    case Type::Int: return "int";
    case Type::Bool: return "bool";
    case Type::Float: return "float";
    case Type::String: return "string";
  }
  return "an extern type";
}

std::string CodeTable::type_name(Type type) const {
  return is_ffi(type) && ffi_row(type) < ffi_types.size() ? ffi_types[ffi_row(type)].name : name_of(type);
}

bool CodeTable::has_cpp() const {
  return !ffi_types.empty() || std::any_of(functions.begin(), functions.end(),
                                           [](const Function& f) { return f.kind != FunctionKind::Draw; });
}
bool CodeTable::has_draws() const {
  return std::any_of(functions.begin(), functions.end(),
                     [](const Function& f) { return f.kind == FunctionKind::Draw; });
}
const std::string& CodeTable::first_cpp() const {
  for (const Function& function : functions) {
    if (function.kind != FunctionKind::Draw) return function.name;
  }
  BIP_ASSERT(!ffi_types.empty(), "no C++ in {} functions", functions.size());
  return ffi_types[0].name;
}

const char* name_of(Op op) { return is_operator(op) ? info_of(op).text : "?"; }

std::uint32_t CodeTable::string(const std::string& text) {
  if (strings.empty()) strings.emplace_back();
  for (std::size_t row = 0; row < strings.size(); ++row) {
    if (strings[row] == text) return static_cast<std::uint32_t>(row);
  }
  BIP_ASSERT(strings[0].empty(), "row 0 of the strings is not empty: {}", strings[0]);
  strings.push_back(text);
  return static_cast<std::uint32_t>(strings.size() - 1);
}

}  // namespace bip
