// Messages in the text of .msg and .action files, of ROS 2 and of ROS 1.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "compiler/ros2/messages.hpp"

namespace bip::ros2 {

/// ROS 1 has no bounds of texts and sequences, and no initial values.
enum class Dialect : std::uint8_t { Ros2, Ros1 };

[[nodiscard]] constexpr bool is_small(char c) { return c >= 'a' && c <= 'z'; }
[[nodiscard]] constexpr bool is_large(char c) { return c >= 'A' && c <= 'Z'; }
[[nodiscard]] constexpr char small(char c) { return is_large(c) ? static_cast<char>(c - 'A' + 'a') : c; }
[[nodiscard]] constexpr char large(char c) { return is_small(c) ? static_cast<char>(c - 'a' + 'A') : c; }
/// "maxSpeed", "X": "max_speed", "x".
[[nodiscard]] std::string snake(const std::string& name);
/// "float64[3]". Messages of `package` are written without its name.
[[nodiscard]] std::string type_text(const Field& field, const std::string& package, Dialect dialect);
/// A line "int32 MODE_SLOW=1" for each word of an enumeration.
[[nodiscard]] std::string constants_text(const std::vector<Field>& fields);
/// The constants, then a line for each field.
[[nodiscard]] std::string fields_text(const std::vector<Field>& fields, const std::string& package, Dialect dialect);

}  // namespace bip::ros2
