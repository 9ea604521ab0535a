// Assertions for our own bugs. User input never reaches one.
#pragma once
#include <string_view>

namespace bip {
/// Prints the place and what was being done, then exits with code 70.
[[noreturn]] void report_bug(const char* what, const char* file, int line);

/// Says what is being done while it lives: "while flattening connector `sync`". `doing` and `what` must outlive it.
class StageScope {
 public:
  StageScope(const char* doing, std::string_view what);
  ~StageScope();
  StageScope(const StageScope&) = delete;
  StageScope& operator=(const StageScope&) = delete;

 private:
  friend void report_bug(const char* what, const char* file, int line);
  const char* doing_;
  std::string_view what_;
  const StageScope* outer_;
};
}  // namespace bip

#define BIP_ASSERT(cond)                                       \
  do {                                                         \
    if (!(cond)) ::bip::report_bug(#cond, __FILE__, __LINE__); \
  } while (false)
#define BIP_UNREACHABLE(what) ::bip::report_bug(what, __FILE__, __LINE__)
