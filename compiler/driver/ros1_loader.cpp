// Finds and opens libbipc_ros1.so: see ros1_loader.hpp.
#include "compiler/driver/ros1_loader.hpp"

#include "compiler/pipeline/plugin.hpp"
#include "compiler/roscpp/plugin.hpp"

namespace bip::driver {

Result<const ros1::TopicBusFactory*> load_ros1() {
  constexpr pipeline::Plugin kRos1{
      .file = "libbipc_ros1.so",
      .what = "no ROS 1",
      .package = "bipc-ros1",
      .needed_build = "libroscpp-dev",
      .subject = "ROS 1",
      .needed_to_run = "libroscpp4d",
      .abi_name = roscpp::kAbiName,
      .abi = roscpp::kPluginAbi,
      .factory_name = roscpp::kFactoryName,
  };
  const Result<void*> factory = pipeline::load_plugin(kRos1);
  if (!factory) return Failure{factory.error()};
  return reinterpret_cast<roscpp::FactoryFn*>(*factory)();
}

}  // namespace bip::driver
