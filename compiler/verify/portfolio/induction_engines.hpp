// Engines that reason about the transition system as a circuit: what structure and affine invariants exclude by one
// solver call each, and IC3, which finds the lemmas that are missing. Complete for finite data, given time; a
// counterexample is replayed with the image's code.
#pragma once
#include "compiler/verify/portfolio/engine.hpp"

namespace bip::verify {

/// Properties of states of systems with many atoms: IC3 that follows some of them (localized_ic3.hpp), a handful at
/// most, or up to half of them.
extern const Engine kFewFollowedEngine;
extern const Engine kLocalizedEngine;
/// Structural and affine invariants, found for this question's bad states; no lemmas. Only its first attempt does
/// something.
extern const Engine kAffineEngine;
/// Lemmas about two components each, learnt from bad states (pair_lemmas.hpp). One attempt.
extern const Engine kPairLemmaEngine;
/// The same if it has not been done, cached lemmas that are inductive (houdini.hpp), then IC3/PDR (ic3.hpp).
extern const Engine kIc3Engine;

/// Returns cubes that may be lemmas, of this transition system.
using LemmaSource = std::function<std::vector<Cube>(const TransitionSystem& machine)>;
/// ByShape: lemmas that say the same of other components (local_lemmas.hpp) are left out together if the proof does not
/// need them.
enum class LemmaReduction : std::uint8_t { None, ByShape };
/// Proves the question by those of the guesses that are inductive, if they suffice; no other lemmas are looked for.
[[nodiscard]] EngineResult try_lemmas(ProofContext& context, const Budget& budget,
                                      const CancellationToken& cancellation, const LemmaSource& guesses,
                                      LemmaReduction reduction = LemmaReduction::None);

}  // namespace bip::verify
