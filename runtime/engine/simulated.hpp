// The simulated engine: a distributed run (runtime/distributed) with all of its nodes, and the network between them, in
// one thread, by a seed. The same seed gives the same run, whatever goes wrong in it.
//
// Each node takes turns: it begins a step that it coordinates, or runs an action of an atom that is at home there. The
// steps, in the order in which they begin, are a run of the sequential semantics: the coordinator of a step has heard
// of all that it depends on. Lines and trace have that order, and end where a sequential run would meet a fault.
//
// Models with time: when nothing is at work and nothing is on its way, all nodes pass to the next instant of all of
// them (node_time.hpp). Time of the model and time of the simulated network are two things.
#pragma once
#include <string>

#include "bip/run.hpp"
#include "runtime/core/core.hpp"
#include "runtime/distributed/distribution.hpp"
#include "runtime/distributed/faults.hpp"
#include "runtime/distributed/network.hpp"
#include "runtime/distributed/node.hpp"
#include "runtime/engine/output.hpp"

namespace bip::rt {

struct SimulatedResult {
  End end = End::Limit;
  u64 steps = 0;
  u64 border_steps = 0;                    // of them, those of more than one node
  u64 offers = 0, begins = 0;              // messages
  u64 locks = 0, releases = 0, wakes = 0;  // the same, of split sets
  [[nodiscard]] u64 messages() const { return offers + begins + locks + releases + wakes; }
  NetworkCounts network;
  i64 time = 0;            // ns of the simulation
  std::string lost_nodes;  // of the run that ended because nodes were lost: their story, several lines; empty: none
  std::string warning;     // nodes were lost, and it went on
  u64 checkpoints = 0;     // written
  u64 checkpoint = 0;      // steps before the last one
};

/// Of an initialized core, `resumed` steps after the initial state. Leaves the core in the last state;
/// core.fault() has the fault, if there is one.
[[nodiscard]] SimulatedResult run_simulated(Core& core, const Distribution& distribution, const NetworkFaults& faults,
                                            const RunOptions& options, u64 seed, Output& output, u64 resumed = 0,
                                            const NodeObserver& observer = {});

}  // namespace bip::rt
