// See constant_value.hpp.
#include "compiler/genom/constant_value.hpp"

#include <fmt/format.h>

#include <limits>

#include "runtime/include/bip/assert.hpp"

namespace bip::genom::idl {
namespace {

// The shortest decimal number that is read as the same double, with a point or an exponent.
std::string real_text(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string group_text(const Value& value) {
  const bool is_object = value.kind == ValueKind::Object;
  BIP_ASSERT(!is_object || value.names.size() == value.parts.size(), "{} names of {} members", value.names.size(),
             value.parts.size());
  std::string text(is_object ? "{" : "[");
  for (std::size_t k = 0; k < value.parts.size(); ++k) {
    if (k > 0) text += ",";
    if (is_object) text += "\"" + value.names[k] + "\":";
    text += json_of(value.parts[k]);
  }
  return text + (is_object ? "}" : "]");
}

}  // namespace

std::string_view name_of(ValueKind kind) {
  switch (kind) {
    case ValueKind::None:
    case ValueKind::Error: return "nothing";
    case ValueKind::Integer: return "an integer";
    case ValueKind::Real: return "a floating-point number";
    case ValueKind::Boolean: return "a boolean";
    case ValueKind::Text: return "a string";
    case ValueKind::Enumerator: return "an enumerator";
    case ValueKind::Name: return "a name";
    case ValueKind::Object: return "a group of members";
    case ValueKind::List: return "a list";
  }
  BIP_UNREACHABLE("a kind of value");
}

std::string json_of(const Value& value) {
  switch (value.kind) {
    case ValueKind::None:
    case ValueKind::Error: return {};
    case ValueKind::Integer: return fmt::format("{}", value.integer);
    case ValueKind::Real: return real_text(value.real);
    case ValueKind::Boolean: return value.boolean ? "true" : "false";
    case ValueKind::Text:
    case ValueKind::Enumerator:
    case ValueKind::Name: return "\"" + value.text + "\"";
    case ValueKind::Object:
    case ValueKind::List: return group_text(value);
  }
  BIP_UNREACHABLE("a kind of value");
}

std::string c_expression(const Value& value) {
  BIP_ASSERT(value.kind != ValueKind::Integer || (value.integer >= std::numeric_limits<std::int64_t>::min() &&
                                                  value.integer <= std::numeric_limits<std::uint64_t>::max()),
             "the constant at byte {} needs more than 64 bits", value.range.begin);
  if (value.kind == ValueKind::Enumerator) return value.c_name;
  if (value.kind != ValueKind::Integer) return json_of(value);
  // C has no literal of the smallest number, and the largest ones are unsigned.
  if (value.integer == std::numeric_limits<std::int64_t>::min()) return "-9223372036854775807 - 1";
  return fmt::format("{}{}", value.integer, value.integer > std::numeric_limits<std::int64_t>::max() ? "u" : "");
}

}  // namespace bip::genom::idl
