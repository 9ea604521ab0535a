// BIP_ASSERT (assert.hpp) for headers that an emitted program reads. Where contracts are not checked it needs nothing
// of the standard library: <string> and what comes with it take longer to read than the program itself.
#pragma once

#ifdef BIP_CHECKED
#include "assert.hpp"  // beside this file: the compiler has no other path to it
#else
namespace bip::assertions {

template <class... Arguments>
constexpr void ignore(const Arguments&...) {}

}  // namespace bip::assertions

#define BIP_ASSERT(condition, ...)                                      \
  do {                                                                  \
    if (false) {                                                        \
      ::bip::assertions::ignore((condition)__VA_OPT__(, ) __VA_ARGS__); \
    }                                                                   \
  } while (false)
#endif
