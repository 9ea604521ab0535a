// The entry points of libbipc_ros1.so. They have C names, so that dlsym finds them. C++ types may be passed, because
// program and plug-in are built by one compiler from one tree; `bipc_ros1_abi` detects a plug-in that was not.
#pragma once
#include <cstdint>

#include "compiler/ros1/topic_bus.hpp"

namespace bip::roscpp {

/// Changes whenever a type that crosses changes; the sizes catch a forgotten change.
constexpr std::uint64_t kPluginAbi =
    (std::uint64_t{1} << 48) + (sizeof(ros1::TopicPlan) << 24) + sizeof(ros1::TopicMessage);

extern "C" {
using AbiFn = std::uint64_t();
/// It lives as long as the plug-in.
using FactoryFn = const ros1::TopicBusFactory*();
}
inline constexpr const char* kAbiName = "bipc_ros1_abi";
inline constexpr const char* kFactoryName = "bipc_ros1_factory";

}  // namespace bip::roscpp
