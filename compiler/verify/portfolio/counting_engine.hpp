// Proofs by counting, for properties of states of systems with interchangeable components: how many of these are in
// each local state (counting/counted_net.hpp), and weights of local states whose sum no step raises
// (counting/sub_invariant.hpp). A proof or nothing.
#pragma once
#include "compiler/verify/portfolio/engine.hpp"

namespace bip::verify {

extern const Engine kCountingEngine;

}  // namespace bip::verify
