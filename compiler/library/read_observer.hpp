// `bipc simulate --observe`: what is measured of each run, in words.
//
//   observer = 'count' (CONNECTOR | COMPONENT.PORT) | 'reaches' EXPR | 'time' 'until' EXPR | 'duration' 'of' EXPR
//            | ('max' | 'min' | 'mean' | 'last') EXPR
//
// EXPR is what a property says (compiler/verify/property): of a truth value for the three that ask when or whether it
// holds, of any number or truth value for the others.
#pragma once
#include <string>

#include "compiler/base/result.hpp"
#include "compiler/system/system_ids.hpp"
#include "runtime/engine/simulate.hpp"

namespace bip::library {

/// The error says what is wrong, with a column for an expression.
[[nodiscard]] Result<rt::Observer> read_observer(const std::string& text, const System& system);
/// A number or a truth value, for `--importance`.
[[nodiscard]] Result<std::function<double(const rt::Core&)>> read_number(const std::string& text, const System& system);
/// A condition, for `--stop`.
[[nodiscard]] Result<std::function<bool(const rt::Core&)>> read_condition(const std::string& text,
                                                                          const System& system);

}  // namespace bip::library
