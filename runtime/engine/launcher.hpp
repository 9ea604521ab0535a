// The launcher of a distributed run: starts the nodes as processes (node_process.hpp), gives out the steps that --limit
// allows, puts the steps of all nodes in one order, and finds out how the run ends.
//
// It is no part of a step. Steps are written in the order of their clocks as soon as no earlier one can come and all of
// their parts have ended; that is a run of the sequential semantics, as with simulated.hpp. The run has ended when all
// nodes rest and, counted twice, as many messages have arrived as were sent (Mattern, "Algorithms for distributed
// termination detection", Distributed Computing 2, 1987: the four-counter method).
//
// Models with time: when all rest, it asks each node how far time may pass and which instants it plans, and tells all
// of them the smallest one (node_time.hpp). With the loss of a node time stops.
#pragma once
#include <string>
#include <vector>

#include "runtime/distributed/fabric.hpp"
#include "runtime/engine/simulated.hpp"

namespace bip::rt {

// What the launcher knows of a node at the end; of a lost one, as of its last beat.
struct NodeUse {
  u64 steps = 0;  // that it began
  u64 cpu = 0;    // microseconds, user and system, of all its threads
  bool is_lost = false;
};

struct DistributedResult : SimulatedResult {
  std::string error;           // why the run could not begin; empty: it could
  u64 bytes = 0, refused = 0;  // of frames; frames and connections
  std::vector<NodeUse> use;    // by node
  i64 started = 0;             // ns until all nodes were there
  u64 most_waiting_bytes =
      0;  // greatest size, at any time, of steps that nodes had reported and that waited to be written
};

/// Of an initialized core. Leaves the core in the last state; core.fault() has the fault, if there is one.
[[nodiscard]] DistributedResult run_distributed(Core& core, const Distribution& distribution, const RunOptions& options,
                                                u64 seed, Output& output, u64 resumed = 0);

}  // namespace bip::rt
