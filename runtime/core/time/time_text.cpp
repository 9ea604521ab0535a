// See time_text.hpp.
#include "runtime/core/time/time_text.hpp"

#include <utility>

#include "runtime/core/text.hpp"

namespace bip::rt {

void append_time(std::string& out, i64 ticks) {
  if (ticks < 0) {
    out += '-';
    ticks = -ticks;
  }
  if (ticks == 0) out += '0';
  constexpr std::pair<i64, const char*> kUnits[] = {{1'000'000'000, "s"}, {1'000'000, "ms"}, {1'000, "us"}, {1, "ns"}};
  for (const auto& [length, name] : kUnits) {
    if (ticks < length) continue;
    append_number(out, static_cast<u64>(ticks / length));
    out += name;
    ticks %= length;
  }
}

void append_interval(std::string& out, const Interval& interval) {
  out += interval.low_open ? "] " : "[ ";
  append_time(out, interval.low - (interval.low_open ? 1 : 0));
  out += ", ";
  if (interval.high == kForever) {
    out += "+INFTY [";
    return;
  }
  append_time(out, interval.high + (interval.high_open ? 1 : 0));
  out += interval.high_open ? " [" : " ]";
}

}  // namespace bip::rt
