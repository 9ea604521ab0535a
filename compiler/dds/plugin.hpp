// The entry points of libbipc_dds.so. They have C names, so that dlsym finds them. C++ types may be passed, because
// program and plug-in are built by one compiler from one tree; `bipc_dds_abi` detects a plug-in that was not.
#pragma once
#include <cstdint>

#include "compiler/ros2/bus.hpp"

namespace bip::dds {

/// Changes whenever a type that crosses changes; the sizes catch a forgotten change.
constexpr std::uint64_t kPluginAbi =
    (std::uint64_t{1} << 48) + (sizeof(ros2::EndpointPlan) << 24) + (sizeof(ros2::BusPlan) << 8) + sizeof(ros2::Sample);

extern "C" {
using AbiFn = std::uint64_t();
/// It lives as long as the plug-in.
using FactoryFn = const ros2::BusFactory*();
}
inline constexpr const char* kAbiName = "bipc_dds_abi";
inline constexpr const char* kFactoryName = "bipc_dds_factory";

}  // namespace bip::dds
