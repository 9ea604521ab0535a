// Names of the code IR's types and operators, and its string table.
//
// Row 0 of the string table is always "": variables start as zero bits, and that must read as the empty string.
// Interning scans the table: models have tens of string constants, not thousands.
#include "compiler/model/code.hpp"

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

const char* name_of(Op op) {
  switch (op) {
    case Op::ConstInt: return "const_int";
    case Op::ConstBool: return "const_bool";
    case Op::ConstFloat: return "const_float";
    case Op::ConstString: return "const_string";
    case Op::LoadSelf: return "self";
    case Op::LoadBind: return "bind";
    case Op::Call: return "call";
    case Op::IntToFloat: return "int_to_float";
    case Op::Neg: return "neg";
    case Op::Not: return "not";
    case Op::BitNot: return "bit_not";
    case Op::Add: return "add";
    case Op::Sub: return "sub";
    case Op::Mul: return "mul";
    case Op::Div: return "div";
    case Op::Mod: return "mod";
    case Op::BitAnd: return "bit_and";
    case Op::BitOr: return "bit_or";
    case Op::BitXor: return "bit_xor";
    case Op::And: return "and";
    case Op::Or: return "or";
    case Op::Eq: return "eq";
    case Op::Ne: return "ne";
    case Op::Lt: return "lt";
    case Op::Gt: return "gt";
    case Op::Le: return "le";
    case Op::Ge: return "ge";
  }
  return "?";
}

std::uint32_t CodeTable::string(const std::string& text) {
  if (strings.empty()) strings.emplace_back();
  for (std::size_t row = 0; row < strings.size(); ++row) {
    if (strings[row] == text) return static_cast<std::uint32_t>(row);
  }
  strings.push_back(text);
  return static_cast<std::uint32_t>(strings.size() - 1);
}

}  // namespace bip
