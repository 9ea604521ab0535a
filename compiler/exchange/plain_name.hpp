// Names as they may stand in comments and strings of any format.
#pragma once
#include <string>

namespace bip::exchange {

/// Returns the name with `_` in place of all that is neither a letter, a digit nor one of `_.[](), -`.
[[nodiscard]] std::string plain_name(const std::string& name);

}  // namespace bip::exchange
