// Loads libbipc_zmq.so, the network of runs on several processes.
#pragma once
#include "compiler/base/result.hpp"
#include "runtime/distributed/fabric.hpp"

namespace bip::pipeline {

/// The fabrics of the plug-in, which stays loaded. A failure says what to install.
[[nodiscard]] Result<const rt::FabricFactory*> load_fabric();

}  // namespace bip::pipeline
