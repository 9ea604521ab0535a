// The node processes of a run on one machine: children of this process, which end with it. Their ends are files that a
// wait can watch.
#pragma once
#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

#include "runtime/core/link/tables.hpp"
#include "runtime/distributed/fabric.hpp"

namespace bip::rt {

/// How a process that was not asked to end has ended.
struct EndedNode {
  u32 node = 0;
  std::string how;  // "killed by signal 9", "exit code 3"
};

class NodeTeam {
 public:
  NodeTeam() = default;
  NodeTeam(const NodeTeam&) = delete;
  NodeTeam& operator=(const NodeTeam&) = delete;
  /// Kills those that still run, and removes the sockets.
  ~NodeTeam();

  /// Makes keys and a folder for sockets that only this user may enter, and starts the nodes: each calls `live` with
  /// its number and plan, and ends with what that returns. Returns why it cannot be; empty: it could.
  [[nodiscard]] std::string start(u32 nodes, const FabricFactory& fabrics,
                                  const std::function<int(u32, const FabricPlan&)>& live);
  /// Of a run on several hosts: starts the one node that is on this one, with the number 0.
  [[nodiscard]] std::string start_first(const FabricPlan& plan, const std::function<int()>& live);
  /// The launcher's.
  [[nodiscard]] const FabricPlan& plan() const { return plan_; }
  /// Readable when processes have ended.
  [[nodiscard]] const std::vector<int>& files() const { return files_; }
  /// Those that ended since.
  [[nodiscard]] std::vector<EndedNode> take_ended();
  /// What the node's process does, for a person: "its process 4711 is stopped".
  [[nodiscard]] std::string state_of(u32 node) const;
  /// Waits until all have ended, or so many ms.
  void wait_for_all(int ms);

 private:
  struct Child {
    pid_t process = 0;  // 0: ended
    int file = -1;
  };
  void close_file(Child& child);
  [[nodiscard]] std::string start_child(const std::function<int()>& live);

  FabricPlan plan_;
  std::string folder_;
  std::vector<Child> children_;
  std::vector<int> files_;
};

}  // namespace bip::rt
