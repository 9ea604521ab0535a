// libbipc_ros1.so: roscpp as a plug-in, so that only `bipc ros1` loads it.
#include "compiler/roscpp/plugin.hpp"

#include "compiler/roscpp/node_topics.hpp"

namespace {

class NodeFactory final : public bip::ros1::TopicBusFactory {
 public:
  [[nodiscard]] bip::Result<std::unique_ptr<bip::ros1::TopicBus>> open(const std::string& node) const override {
    return bip::roscpp::open_node(node);
  }
};

}  // namespace

extern "C" {

std::uint64_t bipc_ros1_abi();
const bip::ros1::TopicBusFactory* bipc_ros1_factory();

std::uint64_t bipc_ros1_abi() { return bip::roscpp::kPluginAbi; }

const bip::ros1::TopicBusFactory* bipc_ros1_factory() {
  static const NodeFactory factory;
  return &factory;
}

}  // extern "C"
