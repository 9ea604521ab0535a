// See check_scalar.hpp.
#include "compiler/genom/check_scalar.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "runtime/include/bip/assert.hpp"

namespace bip::genom::idl {
namespace {

bool is_primitive_value(const PrimitiveType& row, ValueKind kind) {
  switch (row.kind) {
    case PrimitiveKind::Boolean: return kind == ValueKind::Boolean;
    case PrimitiveKind::Character: return kind == ValueKind::Text;
    case PrimitiveKind::Integer: return kind == ValueKind::Integer;
    case PrimitiveKind::Real: return kind == ValueKind::Integer || kind == ValueKind::Real;
    case PrimitiveKind::Any: return true;
  }
  BIP_UNREACHABLE("a kind of primitive types");
}

bool is_value_of(const Type& plain, ValueKind kind) {
  switch (plain.kind) {
    case Kind::Primitive: {
      const PrimitiveType* const row = find_primitive_type(plain.c_name);
      return row == nullptr || is_primitive_value(*row, kind);
    }
    case Kind::String: return kind == ValueKind::Text;
    case Kind::Enum: return kind == ValueKind::Enumerator;
    case Kind::Native: return true;
    case Kind::Sequence:
    case Kind::Array:
    case Kind::Struct:
    case Kind::Union: return false;
    case Kind::Optional:
    case Kind::Alias: return true;
  }
  BIP_UNREACHABLE("a kind of types");
}

// In bytes, of a text as it is written: an escape is one byte at least.
std::int64_t least_length(std::string_view text) {
  std::int64_t length = 0;
  for (std::size_t k = 0; k < text.size(); ++k, ++length) {
    if (text[k] == '\\') k += text.substr(k).starts_with("\\u") ? 5 : 1;
  }
  return length;
}

// Of type `float`: beyond its numbers?
bool is_too_large(const PrimitiveType& row, const Value& value) {
  return row.kind == PrimitiveKind::Real && row.c_name == "float" && value.kind == ValueKind::Real &&
         std::fabs(value.real) > static_cast<double>(std::numeric_limits<float>::max());
}

}  // namespace

std::string type_text(const Type& plain) {
  if (!plain.full_name.empty()) return plain.full_name;
  switch (plain.kind) {
    case Kind::String: return plain.bound == 0 ? "string" : fmt::format("string<{}>", plain.bound);
    case Kind::Sequence: return "sequence";
    case Kind::Optional: return "optional";
    case Kind::Array: return "array";
    case Kind::Primitive:
    case Kind::Struct:
    case Kind::Union:
    case Kind::Enum:
    case Kind::Native:
    case Kind::Alias: break;
  }
  const PrimitiveType* const row = find_primitive_type(plain.c_name);
  return row != nullptr ? std::string(row->idl_name) : plain.c_name;
}

void check_scalar(const Type& plain, const Value& value, std::string_view what, SourceRange range, Diagnostics& diags) {
  BIP_ASSERT(plain.kind != Kind::Alias, "type `{}` stands for another one", plain.c_name);
  if (value.kind == ValueKind::None || value.kind == ValueKind::Error) return;
  if (!is_value_of(plain, value.kind)) {
    diags.report(Diag::kB6032, range, what, name_of(value.kind), type_text(plain));
    return;
  }
  if (plain.kind == Kind::String && plain.bound != 0 && least_length(value.text) > plain.bound) {
    diags.report(Diag::kB6010, range, fmt::format("the length of {}", what), least_length(value.text), 0, plain.bound);
    return;
  }
  const PrimitiveType* const row = plain.kind == Kind::Primitive ? find_primitive_type(plain.c_name) : nullptr;
  if (row != nullptr && is_too_large(*row, value)) {
    constexpr float kMost = std::numeric_limits<float>::max();
    diags.report(Diag::kB6010, range, what, json_of(value), -kMost, kMost);
    return;
  }
  if (row == nullptr || row->kind != PrimitiveKind::Integer || value.kind != ValueKind::Integer) return;
  if (value.integer < row->low || value.integer > row->high)
    diags.report(Diag::kB6010, range, what, fmt::format("{}", value.integer), fmt::format("{}", row->low),
                 fmt::format("{}", row->high));
}

Value as_type(const Type& plain, Value value) {
  BIP_ASSERT(plain.kind != Kind::Alias, "type `{}` stands for another one", plain.c_name);
  const PrimitiveType* const row = plain.kind == Kind::Primitive ? find_primitive_type(plain.c_name) : nullptr;
  if (row != nullptr && row->kind == PrimitiveKind::Real && value.kind == ValueKind::Integer) {
    value.kind = ValueKind::Real;
    value.real = static_cast<double>(value.integer);
  }
  return value;
}

}  // namespace bip::genom::idl
