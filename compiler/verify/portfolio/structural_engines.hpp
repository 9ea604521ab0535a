// Engines that reason about the structure alone: traps, place invariants and state-machine components exclude
// candidates for a deadlock (prove_by_invariants.hpp). Complete for no class of systems, but mostly enough, and fast.
#pragma once
#include "compiler/verify/portfolio/engine.hpp"

namespace bip::verify {

/// Invariants over modes that distinguish the values which connectors give at ports (port_uses.hpp). Gives up after one
/// attempt. With a certificate wanted it answers only if the proof can be projected to a form that certificates have.
extern const Engine kPortUseEngine;
/// Invariants over plain modes. Computes the reachable modes for all later engines, whatever the question; a candidate
/// that no invariant excludes is searched for by a walk, which may find a counterexample.
extern const Engine kInvariantEngine;

}  // namespace bip::verify
