// See plugin.hpp.
#include "compiler/pipeline/plugin.hpp"

#include <dlfcn.h>

#include <filesystem>

#include <fmt/format.h>

#include "compiler/pipeline/parts.hpp"

namespace bip::pipeline {

Result<void*> load_plugin(const Plugin& plugin) {
  std::error_code error;
  std::filesystem::path path;
  for (const std::filesystem::path& candidate : places_of_part(plugin.file)) {
    if (path.empty() && std::filesystem::exists(candidate, error)) path = candidate;
  }
  if (path.empty())
    return Failure{
        fmt::format("this bipc has {}: `{}` is not beside it; the package {} has it, and a build where {} is "
                    "installed makes it",
                    plugin.what, plugin.file, plugin.package, plugin.needed_build)};
  void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* reason = dlerror();
    return Failure{fmt::format("{} does not load; it needs the Debian package {}: {}", plugin.subject,
                               plugin.needed_to_run, reason != nullptr ? reason : "unknown reason")};
  }
  auto* abi = reinterpret_cast<std::uint64_t (*)()>(dlsym(library, plugin.abi_name));
  void* factory = dlsym(library, plugin.factory_name);
  if (abi == nullptr || factory == nullptr || abi() != plugin.abi)
    return Failure{fmt::format("`{}` belongs to another build of bipc; build both together", path.string())};
  return factory;
}

}  // namespace bip::pipeline
