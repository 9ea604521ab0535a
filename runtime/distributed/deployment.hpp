// A run whose nodes are on several hosts, as one of them sees it: which one it is, where the others are, whose keys are
// known. The node with the number 0 has the launcher beside it, in a process of its own.
#pragma once
#include <string>
#include <vector>

#include "runtime/distributed/fabric.hpp"

namespace bip::rt {

/// When and how a node that stands still stops its robot (runtime/engine/stall_watch.hpp).
struct StallOptions {
  std::int64_t after = 0;                    // ns of the wall clock without the end of a step; 0: there is no watch
  void (*stop)(const char* why) = nullptr;   // stops the robot; null: a stall is reported only
  void (*go_on)(const char* why) = nullptr;  // called when steps end again; may be null
  std::string stop_name;                     // for messages
};

struct Deployment {
  std::uint32_t self = 0;
  std::string model;  // names everything that all nodes must have alike
  // By node.
  std::vector<std::string> names;
  std::vector<std::string> addresses;  // HOST:PORT
  std::vector<std::string> open_keys;  // the launcher's is the last
  std::string listen;                  // where this node listens, ADDRESS:PORT; ADDRESS may be `*`
  FabricKeys keys;
  FabricKeys launcher_keys;  // of node 0; of others empty
  StallOptions stall;

  [[nodiscard]] std::uint32_t launcher() const { return static_cast<std::uint32_t>(names.size()); }
};

/// What the fabric of this node needs, or that of the launcher beside it.
[[nodiscard]] FabricPlan node_plan(const Deployment& deployment);
[[nodiscard]] FabricPlan launcher_plan(const Deployment& deployment);

}  // namespace bip::rt
