// Proves a question by lemmas about neighbours (local_lemmas.hpp): states are sampled by runs of the core, what they do
// not refute is tried with Houdini.
#pragma once
#include "compiler/verify/portfolio/engine.hpp"

namespace bip::verify {

/// For systems whose states can be visited. One attempt; it has no answer if the lemmas do not suffice.
extern const Engine kLocalLemmaEngine;

}  // namespace bip::verify
