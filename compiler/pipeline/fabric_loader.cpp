// Finds and opens libbipc_zmq.so: see fabric_loader.hpp.
#include "compiler/pipeline/fabric_loader.hpp"

#include <dlfcn.h>

#include <filesystem>

#include "compiler/pipeline/parts.hpp"
#include "compiler/zmq/plugin.hpp"

namespace bip::pipeline {
namespace {

constexpr const char* kFabricFile = "libbipc_zmq.so";

}  // namespace

Result<const rt::FabricFactory*> load_fabric() {
  std::error_code error;
  std::filesystem::path path;
  for (const std::filesystem::path& candidate : places_of_part(kFabricFile)) {
    if (path.empty() && std::filesystem::exists(candidate, error)) path = candidate;
  }
  if (path.empty())
    return Failure{
        std::string("this bipc has no network: `") + kFabricFile +
        "` is not beside it; the package bipc-distributed has it, and a build where libzmq3-dev is installed "
        "makes it"};
  void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* reason = dlerror();
    return Failure{std::string("the network does not load; it needs the Debian package libzmq5: ") +
                   (reason != nullptr ? reason : "unknown reason")};
  }
  auto* abi = reinterpret_cast<zmq_fabric::AbiFn*>(dlsym(library, zmq_fabric::kAbiName));
  auto* factory = reinterpret_cast<zmq_fabric::FactoryFn*>(dlsym(library, zmq_fabric::kFactoryName));
  if (abi == nullptr || factory == nullptr || abi() != zmq_fabric::kPluginAbi)
    return Failure{"`" + path.string() + "` belongs to another build of bipc; build both together"};
  return factory();
}

}  // namespace bip::pipeline
