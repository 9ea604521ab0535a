// Reuses the proof of an earlier run, and stores the one of this run (proof_cache.hpp). Nothing in a cache is trusted:
// invariants are checked by structure, lemmas by the solver, a counterexample by the engine. What does not hold is
// dropped, and what is missing is found as if there were no cache.
#pragma once
#include "compiler/verify/portfolio/decision.hpp"
#include "compiler/verify/portfolio/engine.hpp"

namespace bip::verify {

/// Replays the cached counterexample or checks the cached lemmas of this very system. Cached invariants need no attempt
/// of their own: the engines of structure begin with them.
extern const Engine kCachedProofEngine;

/// Reads into the context what the cache has about the question. Without cache, or if an atom has too many local
/// states, nothing. Cost: ProofCache::recall.
void load_cached_proof(ProofContext& context);

/// Stores the decision's evidence if it was expensive and is not what the cache has already. Cost: ProofCache::store.
void store_proof(const ProofContext& context, const Decision& decision);

}  // namespace bip::verify
