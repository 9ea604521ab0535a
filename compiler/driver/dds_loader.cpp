// Finds and opens libbipc_dds.so: see dds_loader.hpp.
#include "compiler/driver/dds_loader.hpp"

#include "compiler/dds/plugin.hpp"
#include "compiler/pipeline/plugin.hpp"

namespace bip::driver {

Result<const ros2::BusFactory*> load_dds() {
  constexpr pipeline::Plugin kDds{
      .file = "libbipc_dds.so",
      .what = "no DDS",
      .package = "bipc-ros2",
      .needed_build = "cyclonedds-dev",
      .subject = "DDS",
      .needed_to_run = "libddsc0debian",
      .abi_name = dds::kAbiName,
      .abi = dds::kPluginAbi,
      .factory_name = dds::kFactoryName,
  };
  const Result<void*> factory = pipeline::load_plugin(kDds);
  if (!factory) return Failure{factory.error()};
  return reinterpret_cast<dds::FactoryFn*>(*factory)();
}

}  // namespace bip::driver
