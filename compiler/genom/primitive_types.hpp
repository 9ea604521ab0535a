// The primitive types of IDL: their names in descriptions and in C, and which values they have (OMG
// IDL 4.2, 7.4.1.4.4).
#pragma once
#include <cstdint>
#include <limits>
#include <string_view>

namespace bip::genom::idl {

/// Holds the integers of all primitive types, signed and unsigned.
__extension__ using WideInteger = __int128;

enum class PrimitiveKind : std::uint8_t { Boolean, Character, Integer, Real, Any };

/// `low` and `high` are of integers. `is_checked_only`: codels in C and C++ cannot have it.
struct PrimitiveType {
  std::string_view idl_name, c_name;
  PrimitiveKind kind = PrimitiveKind::Any;
  int bits = 0;  // of integers
  WideInteger low = 0, high = 0;
  bool is_checked_only = false;
  [[nodiscard]] constexpr bool is_unsigned() const { return kind == PrimitiveKind::Integer && low == 0; }
};

namespace detail {
template <class Number>
constexpr PrimitiveType integer_type(std::string_view idl_name, std::string_view c_name) {
  return {idl_name,
          c_name,
          PrimitiveKind::Integer,
          static_cast<int>(sizeof(Number) * 8),
          std::numeric_limits<Number>::min(),
          std::numeric_limits<Number>::max()};
}
}  // namespace detail

inline constexpr PrimitiveType kPrimitiveTypes[] = {
    {"boolean", "bool", PrimitiveKind::Boolean},
    {"char", "char", PrimitiveKind::Character},
    detail::integer_type<std::uint8_t>("octet", "uint8_t"),
    detail::integer_type<std::int16_t>("short", "int16_t"),
    detail::integer_type<std::uint16_t>("unsigned short", "uint16_t"),
    detail::integer_type<std::int32_t>("long", "int32_t"),
    detail::integer_type<std::uint32_t>("unsigned long", "uint32_t"),
    detail::integer_type<std::int64_t>("long long", "int64_t"),
    detail::integer_type<std::uint64_t>("unsigned long long", "uint64_t"),
    {"float", "float", PrimitiveKind::Real},
    {"double", "double", PrimitiveKind::Real},
    {"any", "any", PrimitiveKind::Any, 0, 0, 0, true},
    {"wchar", "wchar", PrimitiveKind::Character, 0, 0, 0, true},
    {"wstring", "wstring", PrimitiveKind::Any, 0, 0, 0, true},
    {"long double", "long double", PrimitiveKind::Real, 0, 0, 0, true}};

/// The row of `c_name`; null: there is none.
[[nodiscard]] constexpr const PrimitiveType* find_primitive_type(std::string_view c_name) {
  for (const PrimitiveType& row : kPrimitiveTypes) {
    if (row.c_name == c_name) return &row;
  }
  return nullptr;
}

}  // namespace bip::genom::idl
