// Prints single values of the emitted tables.
#pragma once
#include <initializer_list>
#include <string>

#include "compiler/emit_cpp/writer.hpp"
#include "runtime/include/bip/image.hpp"

namespace bip::emit_cpp {

[[nodiscard]] inline std::string braces(std::initializer_list<std::string> cells) {
  std::string out = "{";
  for (const std::string& cell : cells) {
    if (out.size() > 1) out += ", ";
    out += cell;
  }
  return out + "}";
}

[[nodiscard]] inline std::string bool_text(bool value) { return value ? "true" : "false"; }
[[nodiscard]] inline std::string row_text(std::uint32_t row) {
  return row == rt::kNone ? "kNone" : std::to_string(row);
}
[[nodiscard]] inline std::string loc_text(const rt::SourceLine& loc) {
  return braces({std::to_string(loc.file), std::to_string(loc.line), std::to_string(loc.column)});
}

[[nodiscard]] inline std::string join(const rt::Span<std::uint32_t>& items) {
  std::string out;
  for (const std::uint32_t item : items) {
    if (!out.empty()) out += ", ";
    out += row_text(item);
  }
  return out;
}

}  // namespace bip::emit_cpp
