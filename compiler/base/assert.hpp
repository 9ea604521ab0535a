// Assertions for our own bugs. User input never reaches one.
#pragma once

namespace bip {
/// Prints the place and what was being done, then exits with code 70.
[[noreturn]] void report_bug(const char* what, const char* file, int line);
}  // namespace bip

#define BIP_ASSERT(cond)                                              \
  do {                                                                \
    if (!(cond)) ::bip::report_bug(#cond, __FILE__, __LINE__);        \
  } while (false)
#define BIP_UNREACHABLE(what) ::bip::report_bug(what, __FILE__, __LINE__)
