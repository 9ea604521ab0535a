// .bsys, the text form of a System: round-tripping, versioned, and stable for other tools.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "compiler/base/result.hpp"
#include "compiler/system/system_ids.hpp"

namespace bip::system {

/// The whole system as text, first line `(bsys 1)`. Deterministic.
[[nodiscard]] std::string print(const System& system);

/// Reads .bsys text. Any input, however broken, gives a System that `validate` accepts or a failure
/// "line:column: what is wrong".
[[nodiscard]] Result<System> parse_bsys(std::string_view text);

/// Every broken promise of system.hpp, types.hpp and code.hpp (ids in range, types agree, define trees are trees,
/// order of connectors, clauses are interactions of their define, …); empty if sound.
[[nodiscard]] std::vector<std::string> validate(const System& system);

}  // namespace bip::system
