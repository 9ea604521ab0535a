// Loads libbipc_dds.so, through which `bipc ros2` reaches DDS.
#pragma once
#include "compiler/base/result.hpp"
#include "compiler/ros2/bus.hpp"

namespace bip::driver {

/// The plug-in, which stays loaded. A failure says what to install.
[[nodiscard]] Result<const ros2::BusFactory*> load_dds();

}  // namespace bip::driver
