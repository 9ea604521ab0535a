// Lemmas learnt from small instances of the model (scaling/learn_lemmas.hpp), tried for the one in question. A proof,
// with these lemmas as its evidence, or nothing.
#pragma once
#include "compiler/verify/portfolio/engine.hpp"

namespace bip::verify {

extern const Engine kSmallInstanceEngine;

}  // namespace bip::verify
