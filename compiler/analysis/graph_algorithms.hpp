// Strongly connected components, cycles and topological orders: the compiler's name for the one implementation, which
// is the runtime's because the runtime includes nothing of the compiler.
#pragma once
#include "runtime/core/graph_algorithms.hpp"  // IWYU pragma: export
