// Assertions (bip/assert.hpp) that also say which stage of the compiler was at work.
#pragma once
#include <string_view>

#include "runtime/include/bip/assert.hpp"

namespace bip {
/// Says what is being done while it lives: "while flattening connector `sync`". `doing` and `what` must outlive it.
class StageScope {
 public:
  StageScope(const char* doing, std::string_view what);
  ~StageScope();
  StageScope(const StageScope&) = delete;
  StageScope& operator=(const StageScope&) = delete;

 private:
  friend void print_stages();
  const char* doing_;
  std::string_view what_;
  const StageScope* outer_;
};
}  // namespace bip
