// libbipc_zmq.so: the fabric as a plug-in, so that only runs on several processes load libzmq.
#include "compiler/zmq/plugin.hpp"

#include "compiler/zmq/zmq_fabric.hpp"

namespace {

using namespace bip;

class Factory final : public rt::FabricFactory {
 public:
  [[nodiscard]] rt::FabricKeys make_keys() const override { return zmq_fabric::make_keys(); }
  [[nodiscard]] Result<std::unique_ptr<rt::Fabric>> open(const rt::FabricPlan& plan) const override {
    return zmq_fabric::open(plan);
  }
  [[nodiscard]] std::string version() const override { return zmq_fabric::version(); }
};

}  // namespace

extern "C" {

std::uint64_t bipc_zmq_abi();
const bip::rt::FabricFactory* bipc_zmq_factory();

std::uint64_t bipc_zmq_abi() { return bip::zmq_fabric::kPluginAbi; }

const bip::rt::FabricFactory* bipc_zmq_factory() {
  static const Factory factory;
  return &factory;
}

}  // extern "C"
