// libbipc_dds.so: Cyclone DDS as a plug-in, so that only `bipc ros2` loads it.
#include "compiler/dds/plugin.hpp"

#include "compiler/dds/cyclone_bus.hpp"

namespace {

class CycloneFactory final : public bip::ros2::BusFactory {
 public:
  [[nodiscard]] bip::Result<std::unique_ptr<bip::ros2::Bus>> open(const bip::ros2::BusPlan& plan) const override {
    return bip::dds::open_bus(plan);
  }
};

}  // namespace

extern "C" {

std::uint64_t bipc_dds_abi();
const bip::ros2::BusFactory* bipc_dds_factory();

std::uint64_t bipc_dds_abi() { return bip::dds::kPluginAbi; }

const bip::ros2::BusFactory* bipc_dds_factory() {
  static const CycloneFactory factory;
  return &factory;
}

}  // extern "C"
