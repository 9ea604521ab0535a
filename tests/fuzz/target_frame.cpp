// What peers of a distributed run send: a frame of the run that can be written again, a greeting, or nothing. Whatever
// it is, the links go on, and so does a node that takes its messages.
#include "compiler/interp/interp.hpp"
#include "compiler/lower/lower.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "runtime/core/core.hpp"
#include "runtime/distributed/greeting.hpp"
#include "runtime/distributed/node.hpp"
#include "runtime/distributed/station.hpp"
#include "tests/fuzz/targets.hpp"

namespace bip::fuzz {
namespace {

// An automaton on each of two nodes, and a net on the second, with values that cross. What is on the second is locked
// for the first.
constexpr const char* kPeers =
    "package fuzz\n"
    "  port type Level(int v, float w)\n"
    "  connector type Two(Level a, Level b)\n"
    "    define a b\n"
    "    on a b down { a.v = b.v; }\n"
    "  end\n"
    "  atom type Tank()\n"
    "    data int level = 0\n"
    "    data float heat = 1.5\n"
    "    export port Level fill(level, heat), drain(level, heat)\n"
    "    place LOW, HIGH\n"
    "    initial to LOW\n"
    "    on fill from LOW to HIGH do { level = level + 1; }\n"
    "    on drain from HIGH to LOW\n"
    "  end\n"
    "  atom type Net()\n"
    "    data int level = 0\n"
    "    data float heat = 1.5\n"
    "    export port Level fill(level, heat)\n"
    "    place A, B, C\n"
    "    initial to A, B\n"
    "    on fill from A, B to C\n"
    "  end\n"
    "  compound type Root()\n"
    "    component Tank tank(), other()\n"
    "    component Net net()\n"
    "    connector Two fills(tank.fill, other.fill), drains(tank.drain, other.drain), nets(tank.fill, net.fill)\n"
    "    connector Two pairs(other.fill, net.fill)\n"
    "  end\n"
    "end\n";

struct Peers {
  pipeline::Compilation compilation{pipeline::CompileOptions{}};
  std::unique_ptr<interp::Interpreter> interpreter;
  std::unique_ptr<rt::Core> core;
  rt::Distribution distribution;
  rt::State initial;

  Peers() {
    compilation.open_texts["/nowhere/peers.bip"] = kPeers;
    if (!pipeline::compile(compilation, "/nowhere/peers.bip", pipeline::Stage::Image)) return;
    interpreter = std::make_unique<interp::Interpreter>(*compilation.lowered);
    core = std::make_unique<rt::Core>(compilation.lowered->image);
    rt::Placement placement{{"1", "2"}, {0, 1, 1}};
    placement.split_above = 1;
    distribution = rt::distribute(core->tables(), core->priorities(), placement);
    if (core->initialize()) initial = core->snapshot();
  }
};

class NoFabric final : public rt::Fabric {
 public:
  void send(std::uint32_t, std::string_view) override {}
  bool wait(int, const std::vector<int>&, std::vector<rt::Arrival>&) override { return false; }
  [[nodiscard]] rt::FabricCounts counts() override { return {}; }
};

// Does what the node may do now.
void go_on(rt::Node& node) {
  std::vector<rt::u32> atoms;
  if (node.try_count() != 0) node.try_lock(0);
  const rt::InteractionId locked = node.locked_interaction();
  for (rt::u64 k = 0; k < node.core().candidate_count(); ++k) {
    const rt::EnabledSet::Position at = node.core().position(k);
    if (locked.is_valid() ? at.interaction != locked : !node.core().partial().is_decided(at.interaction)) continue;
    node.begin(at, 1, atoms);
    break;
  }
  if (node.work_count() != 0) node.run(0);
  node.outbox().clear();
}

}  // namespace

Verdict try_frame(std::string_view input) {
  static const Peers peers;
  if (peers.core == nullptr) return {"frame: the fixed system does not compile", false};
  if (rt::is_greeting(input)) {
    rt::Greeting greeting, again;
    if (!rt::read(input, greeting) || greeting.protocol != rt::kProtocol) return {};
    const std::string text = rt::text_of(greeting);
    return {rt::read(text, again) && rt::text_of(again) == text ? "" : "frame: a greeting reads otherwise", true};
  }
  constexpr rt::u64 kRun = 42;
  const rt::Codec codec(peers.core->tables(), peers.distribution, kRun);
  NoFabric fabric;
  rt::Station station(fabric, codec, 0, 3);
  std::vector<rt::ReceivedMessage> heard;
  station.take({1, std::string(input)}, 1, heard);
  station.send(2);
  station.tick(3);
  rt::Frame frame, again;
  const bool is_read = codec.read(input, 1, 0, frame);
  if (is_read == (station.counts().refused != 0)) return {"frame: what can be read is refused", false};
  // Attempts to lock go from the first node to the second.
  if (!is_read && !codec.read(input, 0, 1, frame)) return {};
  rt::Node node(peers.compilation.lowered->image, {}, peers.distribution, frame.to);
  if (!node.start(peers.initial)) return {"frame: a node cannot start", false};
  // Some messages come together, and some when the node has gone on.
  for (std::size_t k = 0; k < frame.messages.size(); ++k) {
    node.take(frame.messages[k]);
    for (std::size_t turns = 0; turns < k % 3 && !node.is_stopped(); ++turns) go_on(node);
  }
  std::string text, twice;
  codec.write(frame, text);
  if (!codec.read(text, frame.from, frame.to, again)) return {"frame: what was written cannot be read", true};
  codec.write(again, twice);
  return {text == twice ? "" : "frame: a frame reads otherwise", true};
}

}  // namespace bip::fuzz
