// Finds and opens libbipc_zmq.so: see fabric_loader.hpp.
#include "compiler/pipeline/fabric_loader.hpp"

#include "compiler/pipeline/plugin.hpp"
#include "compiler/zmq/plugin.hpp"

namespace bip::pipeline {

Result<const rt::FabricFactory*> load_fabric() {
  constexpr Plugin kNetwork{
      .file = "libbipc_zmq.so",
      .what = "no network",
      .package = "bipc-distributed",
      .needed_build = "libzmq3-dev",
      .subject = "the network",
      .needed_to_run = "libzmq5",
      .abi_name = zmq_fabric::kAbiName,
      .abi = zmq_fabric::kPluginAbi,
      .factory_name = zmq_fabric::kFactoryName,
  };
  const Result<void*> factory = load_plugin(kNetwork);
  if (!factory) return Failure{factory.error()};
  return reinterpret_cast<zmq_fabric::FactoryFn*>(*factory)();
}

}  // namespace bip::pipeline
