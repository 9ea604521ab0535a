// Result<T>, which the compiler shares with the runtime.
#pragma once
#include "runtime/include/bip/result.hpp"  // IWYU pragma: export
