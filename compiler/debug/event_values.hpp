// Values of an event as a person writes them.
#pragma once
#include <string_view>
#include <vector>

#include "bip/events.hpp"

namespace bip::debug {

/// `3 true 2.5 "text" word`: whole numbers, truth values, real numbers; everything else is a text.
[[nodiscard]] std::vector<EventValue> event_values(std::string_view words);

}  // namespace bip::debug
