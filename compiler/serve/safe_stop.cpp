// See safe_stop.hpp.
#include "compiler/serve/safe_stop.hpp"

#include <dlfcn.h>

namespace bip::serve {

Result<SafeStop> find_safe_stop(void* library, const std::string& name, std::int64_t stall_after) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  SafeStop found;
  found.name = name.empty() ? "safe_stop" : name;
  if (library != nullptr) found.stop = reinterpret_cast<void (*)(const char*)>(::dlsym(library, found.name.c_str()));
  if (!name.empty() && found.stop == nullptr)
    return Failure{"the model's C++ has no function `extern \"C\" void " + name + "(const char* why)`"};
  found.stall_after = stall_after >= 0 ? stall_after : found.stop == nullptr ? 0 : kSecond;
  return found;
}

}  // namespace bip::serve
