// Loads libbipc_ros1.so, through which `bipc ros1` reaches ROS 1.
#pragma once
#include "compiler/base/result.hpp"
#include "compiler/ros1/topic_bus.hpp"

namespace bip::driver {

/// The plug-in, which stays loaded. A failure says what to install.
[[nodiscard]] Result<const ros1::TopicBusFactory*> load_ros1();

}  // namespace bip::driver
