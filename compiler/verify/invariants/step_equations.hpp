// What steps may change of a sum, as equations: all choices below a node of the connectors' trees change it by the
// same, and a step by nothing. Unknown p < port_count is what port p changes when it fires.
//
// Cost: linear in the network, whose groups are never expanded.
#pragma once
#include <functional>

#include "compiler/verify/net/net.hpp"
#include "compiler/verify/invariants/sparse_system.hpp"
#include "compiler/verify/net/mode_reachability.hpp"

namespace bip::verify {

/// What a rendezvous changes itself, beside its ports: one row an alternative. None: nothing.
using OwnChanges = std::function<std::vector<SparseSystem::Row>(u32 node)>;

/// Steps that are not reachable by structure say nothing. Stops early where the system has given up.
void add_step_equations(const Net& net, const ModeReachability& reachable, SparseSystem& system,
                        std::vector<SparseSystem::Row>& equations, const OwnChanges& own = {});

}  // namespace bip::verify
