// Which models have instants after which time must not pass, and which are none of their steps: an eager candidate
// whose interval begins with an open bound (`y > 1`). Of the image alone, O(transitions).
#pragma once
#include "bip/image.hpp"

namespace bip::rt {

/// The transitions because of which an eager candidate may have an interval without a first instant.
struct OpenEager {
  const Transition* eager = nullptr;  // null: none may
  const Transition* open_bound = nullptr;
};
[[nodiscard]] OpenEager find_open_eager(const Image& image);
/// May an eager candidate have an interval without a first instant? Images with `@async` are left out: their actions
/// are not executed twice.
[[nodiscard]] bool may_open_eagerly(const Image& image);

}  // namespace bip::rt
