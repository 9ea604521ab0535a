// C++ on which no state depends: calls whose result is not used, as those of `printf`, and assignments from C++ to data
// that are never read.
//
// Without it a model has the same states and steps, and they can be visited. C++ is taken to return, without an
// exception, and to change nothing but what it gets by reference. Linear in the code, times the longest chain of
// assignments.
#pragma once
#include <optional>
#include <vector>

#include "compiler/system/system_ids.hpp"

namespace bip::verify {

/// Do components or connectors call C++, and not only types that nothing is of?
[[nodiscard]] bool calls_cpp(const System& system);
/// The system without calls of C++; nothing if it has none, or if what C++ computes decides about states. `asked`: data
/// that is read elsewhere.
[[nodiscard]] std::optional<System> without_unread_cpp(const System& system, const std::vector<DataRef>& asked);

}  // namespace bip::verify
