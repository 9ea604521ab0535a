// The variables that a piece of C code can name: those of an atom (`x`), of a connector and its ports (`p.x`).
#pragma once
#include <cstdint>
#include <map>
#include <string>

#include "compiler/syntax/bip1.hpp"

namespace bip::migrate {

/// Object: of a C++ type. Unknown: the model does not say.
enum class ValueKind : std::uint8_t { Int, Bool, Float, String, Object, Clock, Unknown };

struct VariableType {
  ValueKind kind = ValueKind::Unknown;
  std::string bip;  // `int`, or the name of an extern type
  std::string cpp;  // `int`, `unsigned int`
};
struct Variable {
  VariableType type;
  bool is_writable = true;
};
/// By the name in the source, with dots.
using Variables = std::map<std::string, Variable>;

/// `a.b.c`
[[nodiscard]] inline std::string joined(const syntax::bip1::Path& path, std::string_view sign = ".") {
  std::string out;
  for (const syntax::Name& name : path) {
    if (!out.empty()) out += sign;
    out += name.text;
  }
  return out;
}

}  // namespace bip::migrate
