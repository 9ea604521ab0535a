// The function of the model's C++ that stops the robot when nothing goes on: `bipc serve` and `bipc node` call it.
#pragma once
#include <cstdint>
#include <string>

#include "bip/result.hpp"

namespace bip::serve {

struct SafeStop {
  std::string name;
  void (*stop)(const char* why) = nullptr;  // null: the model's C++ has none
  std::int64_t stall_after = 0;             // ns without the end of a step that are reported; 0: never
};

/// Finds the function in the model's C++ (a handle of dlopen; null: it has none). `name`: that of --safe-stop; empty:
/// `safe_stop`, which need not be there. `stall_after`: ns of --stall-after; below 0: a second if there is a function,
/// else never. Fails with a message if the named function is not there.
[[nodiscard]] Result<SafeStop> find_safe_stop(void* library, const std::string& name, std::int64_t stall_after);

}  // namespace bip::serve
