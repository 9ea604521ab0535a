// Instants and intervals as text.
#pragma once
#include <string>

#include "runtime/core/time/interval.hpp"

namespace bip::rt {

/// `4ms200us939ns`, `6s`, `0`.
void append_time(std::string& out, i64 ticks);
/// `[ 0, 5ms ]`, `] 2s, +INFTY [`.
void append_interval(std::string& out, const Interval& interval);

}  // namespace bip::rt
