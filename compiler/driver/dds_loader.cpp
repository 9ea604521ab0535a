// Finds and opens libbipc_dds.so: see dds_loader.hpp.
#include "compiler/driver/dds_loader.hpp"

#include <dlfcn.h>

#include <filesystem>
#include <string>

#include "compiler/dds/plugin.hpp"
#include "compiler/pipeline/parts.hpp"

namespace bip::driver {

Result<const ros2::BusFactory*> load_dds() {
  constexpr const char* kDdsFile = "libbipc_dds.so";
  std::error_code error;
  std::filesystem::path path;
  for (const std::filesystem::path& candidate : pipeline::places_of_part(kDdsFile)) {
    if (path.empty() && std::filesystem::exists(candidate, error)) path = candidate;
  }
  if (path.empty())
    return Failure{std::string("this bipc has no DDS: `") + kDdsFile +
                   "` is not beside it; the package bipc-ros2 has it, and a build where cyclonedds-dev is installed "
                   "makes it"};
  void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* reason = dlerror();
    return Failure{std::string("DDS does not load; it needs the Debian package libddsc0debian: ") +
                   (reason != nullptr ? reason : "unknown reason")};
  }
  auto* abi = reinterpret_cast<dds::AbiFn*>(dlsym(library, dds::kAbiName));
  auto* factory = reinterpret_cast<dds::FactoryFn*>(dlsym(library, dds::kFactoryName));
  if (abi == nullptr || factory == nullptr || abi() != dds::kPluginAbi)
    return Failure{"`" + path.string() + "` belongs to another build of bipc; build both together"};
  return factory();
}

}  // namespace bip::driver
