// Proves a question by regions of values, neighbourhoods and a linear program (compiler/verify/regions).
#pragma once
#include "compiler/verify/portfolio/engine.hpp"

namespace bip::verify {

/// Deadlock and properties of states of plain rendezvous with ints; no time, no C++. It gives no violation, and no
/// certificate of what neighbourhoods show. A further attempt helps only if the time was too short.
extern const Engine kRegionEngine;

}  // namespace bip::verify
