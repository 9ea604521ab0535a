// Events from outside, as programs give them to a running model: a port by its path, a value for each of its variables.
#pragma once
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace bip {

/// What an event carries for a variable of a port: of the variable's type, or an int for a float.
using EventValue = std::variant<std::int32_t, bool, double, std::string>;

}  // namespace bip
