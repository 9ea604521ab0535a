// Names of ROS 2's topics on DDS, and what its programs read in the user data of an endpoint.
#pragma once
#include <string>

#include "compiler/ros2/bus.hpp"
#include "compiler/ros2/messages.hpp"

namespace bip::ros2 {

/// A topic that clients see as /NAME.
[[nodiscard]] EndpointPlan topic_plan(const Messages& messages, const std::string& name, const std::string& type);

enum class Half : std::uint8_t { Request, Reply };
/// Half of a service /NAME. `id`: one for both halves, by which clients of rmw_cyclonedds find the server.
[[nodiscard]] EndpointPlan service_plan(const Messages& messages, const std::string& name, const std::string& type,
                                        Half half, const std::string& id);
/// An id from the system's random numbers, as rmw_cyclonedds writes it: 16 bytes in hexadecimal, dots between them.
[[nodiscard]] std::string make_service_id();

}  // namespace bip::ros2
