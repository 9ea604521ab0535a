// Proves a property of one or two of many equal components with clocks from the zone graph of two of them and those
// beside them: thread-modular reasoning over pairs.
//
// The components of one array are *alike* if they differ in their numbers at most, and all connectors treat them alike.
// The local system has the two components that the property names and all components outside of the array. A step of a
// third one is a step of its neighbours alone. It is possible only where the third one may be at a place from which it
// takes this step, and at that place together with either of the two: which places two components may be at together
// is what the zone graph says, as all pairs are alike. The least fixpoint of graph and pairs contains every state of
// the whole, seen through any pair. Guards of the third one, of its clocks too, count as true.
//
// Numbers (Fischer's protocol writes who it was) may be parameters of the components that are copied into data outside
// and compared with equality only. Then all numbers but those of the two are one value (scalarsets: C. N. Ip, D. Dill:
// Better Verification Through Symmetry, 1996). Nothing outside may compare two of them with each other.
//
// After C. Flanagan, S. Qadeer: Thread-Modular Model Checking (2003), with pairs instead of single threads and zones
// instead of states. Sound but incomplete: failure implies nothing. Cost: a zone graph of few components per round;
// rounds: at most pairs of places.
#pragma once
#include "compiler/verify/timed/prove_time.hpp"

namespace bip::verify {

/// Properties with `can` depend on the instant and are not proved. `proof.alike` says how many components the pair
/// stands for. `certificate_bytes`: of the text of `proof.rows`; 0: none is wanted.
[[nodiscard]] TimeProof prove_state_by_pairs(const System& system, const Property& property, const ExplorePart& explore,
                                             const CancellationToken& cancellation, const PartLimits& limits = {},
                                             std::size_t certificate_bytes = 0);

}  // namespace bip::verify
