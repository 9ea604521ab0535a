// The entry points of libbipc_zmq.so. They have C names, so that dlsym finds them. C++ types may be passed, because
// program and plug-in are built by one compiler from one tree; `bipc_zmq_abi` detects a plug-in that was not.
#pragma once
#include <cstdint>
#include <string>

#include "runtime/distributed/fabric.hpp"

namespace bip::zmq_fabric {

/// Changes whenever a type that crosses changes; the sizes catch a forgotten change.
constexpr std::uint64_t kPluginAbi =
    (std::uint64_t{1} << 48) + (sizeof(rt::FabricPlan) << 24) + (sizeof(rt::Arrival) << 8) + sizeof(rt::FabricCounts);

extern "C" {
using AbiFn = std::uint64_t();
/// The fabrics that there are; it lives as long as the plug-in.
using FactoryFn = const rt::FabricFactory*();
}
inline constexpr const char* kAbiName = "bipc_zmq_abi";
inline constexpr const char* kFactoryName = "bipc_zmq_factory";

}  // namespace bip::zmq_fabric
