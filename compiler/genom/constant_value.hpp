// Values of constants and initial values of parameters, after constant expressions were folded.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "compiler/genom/primitive_types.hpp"
#include "compiler/source/source.hpp"

namespace bip::genom::idl {

/// Error: the expression has no value, which is reported. Name: no constant or enumerator of the scope; it may be an
/// enumerator of the parameter's type. Object and List: initial values in braces, with and without names of members.
enum class ValueKind : std::uint8_t { None, Error, Integer, Real, Boolean, Text, Enumerator, Name, Object, List };

struct Value {
  ValueKind kind = ValueKind::None;
  SourceRange range{};
  WideInteger integer = 0;
  double real = 0;
  bool boolean = false;
  std::string text{};                // Text: as written, with its escapes; Enumerator, Name: without its scope
  std::string c_name{};              // Enumerator
  std::vector<std::string> names{};  // Object: of the members
  std::vector<Value> parts{};        // Object, List
};

/// "an integer", "a list": for messages.
[[nodiscard]] std::string_view name_of(ValueKind kind);
/// As JSON; nothing for None and Error. Enumerators are strings.
[[nodiscard]] std::string json_of(const Value& value);
/// As an expression of C, of a value that is neither Object nor List.
[[nodiscard]] std::string c_expression(const Value& value);

}  // namespace bip::genom::idl
