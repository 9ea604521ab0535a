// A participant of a DDS domain, by Cyclone DDS 0.10.
#pragma once
#include <memory>

#include "compiler/base/result.hpp"
#include "compiler/ros2/bus.hpp"

namespace bip::dds {

/// Opens one participant. With an interface it stays on that; on the loopback it finds at most 32 participants, by
/// their ports.
[[nodiscard]] Result<std::unique_ptr<ros2::Bus>> open_bus(const ros2::BusPlan& plan);

}  // namespace bip::dds
