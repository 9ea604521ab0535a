// See real_time.hpp.
#include "runtime/engine/real_time.hpp"

#include <bit>

#include "bip/assert.hpp"
#include "runtime/core/text.hpp"
#include "runtime/engine/waker.hpp"

namespace bip::rt {

void RealTime::start(i64 first) {
  BIP_ASSERT(speed_ > 0, "time stands still");
  first_ = first;
  origin_ = wall_clock();
}

i64 RealTime::due(i64 instant) const {
  const auto wanted = static_cast<double>(instant - first_) / speed_;
  return wanted >= static_cast<double>(kMaxTicks) ? kForever : origin_ + static_cast<i64>(wanted);
}

i64 RealTime::now() const {
  const auto passed = static_cast<double>(wall_clock() - origin_) * speed_;
  return passed >= static_cast<double>(kMaxTicks) ? kMaxTicks : first_ + static_cast<i64>(passed);
}

bool RealTime::has_passed(i64 instant) const { return instant != kForever && wall_clock() >= due(instant); }

i64 RealTime::note_late(i64 instant) {
  const i64 late = wall_clock() - due(instant);
  if (late < 0) return 0;
  const auto micros = static_cast<std::uint64_t>(late / 1000);
  ++late_[std::min<std::size_t>(static_cast<std::size_t>(std::bit_width(micros)), late_.size() - 1)];
  most_ = std::max(most_, late);
  return late;
}

void RealTime::append_histogram(std::string& out) const {
  std::uint64_t total = 0, before = 0;
  for (const std::uint64_t count : late_) total += count;
  std::size_t median = 0;
  for (; median + 1 < late_.size() && (before + late_[median]) * 2 < total; ++median) before += late_[median];
  out += "lateness: median below ";
  append_time(out, (i64{1} << median) * 1000);
  out += ", most ";
  append_time(out, most_);
  out += '\n';
  for (std::size_t k = 0; k < late_.size(); ++k) {
    if (late_[k] == 0) continue;
    out += "  below ";
    append_time(out, (i64{1} << k) * 1000);
    out += ": ";
    append_number(out, late_[k]);
    out += '\n';
  }
}

}  // namespace bip::rt
