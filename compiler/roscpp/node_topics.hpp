// A node of ROS 1 over roscpp: topics of serialized messages.
#pragma once
#include <memory>
#include <string>

#include "compiler/ros1/topic_bus.hpp"

namespace bip::roscpp {

/// One node in a process. A failure: there is no master at $ROS_MASTER_URI.
[[nodiscard]] Result<std::unique_ptr<ros1::TopicBus>> open_node(const std::string& name);

}  // namespace bip::roscpp
