// Engines that reason about the transition system as a circuit: what structure and affine invariants exclude by one
// solver call each, and IC3, which finds the lemmas that are missing. Complete for finite data, given time; a
// counterexample is replayed with the image's code.
#pragma once
#include "compiler/verify/portfolio/engine.hpp"

namespace bip::verify {

/// Structural and affine invariants, found for this question's bad states; no lemmas. Only its first attempt does
/// something.
extern const Engine kAffineEngine;
/// The same if it has not been done, cached lemmas that are inductive (houdini.hpp), then IC3/PDR (ic3.hpp).
extern const Engine kIc3Engine;

}  // namespace bip::verify
