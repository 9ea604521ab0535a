// The ground on which Dala drives: flat, but for a field of stones that are lower than the plane of its laser. Metres
// and radians. The field lies where the missions over flat ground do not go.
#pragma once
#include <array>
#include <cmath>

#include "world.hpp"

namespace dala {

struct Stone {
  double x, y, r, h;
};

inline constexpr std::array<Stone, 13> kStones{{{-1.6, -2.9, 0.45, 0.30},
                                                {-0.4, -2.8, 0.45, 0.28},
                                                {0.7, -2.9, 0.45, 0.30},
                                                {2.0, -2.8, 0.50, 0.32},
                                                {3.2, -2.9, 0.45, 0.30},
                                                {-1.0, -4.1, 0.45, 0.30},
                                                {0.2, -4.2, 0.45, 0.30},
                                                {1.9, -4.1, 0.45, 0.28},
                                                {3.0, -4.2, 0.50, 0.32},
                                                {-0.5, -5.3, 0.45, 0.28},
                                                {0.9, -5.4, 0.45, 0.30},
                                                {2.2, -5.3, 0.45, 0.30},
                                                {3.5, -5.4, 0.45, 0.30}}};
inline constexpr double kHighest = 0.32;
struct Field {
  double left, right, bottom, top;
};
inline constexpr Field kField{-2.2, 4.2, -6.0, -2.2};

inline double ground_at(double x, double y) {
  if (x < kField.left || x > kField.right || y < kField.bottom || y > kField.top) return 0;
  double high = 0;
  for (const Stone& s : kStones) {
    const double off = ((x - s.x) * (x - s.x) + (y - s.y) * (y - s.y)) / (s.r * s.r);
    if (off < 1) high = std::max(high, s.h * (1 - off) * (1 - off));
  }
  return high;
}

/// How far a chassis on four wheels is from level: `height` of the places under its wheels.
template <typename Height>
double tilt_over(Height&& height, double x, double y, double heading) {
  constexpr double kForward = 0.25, kSide = 0.2;
  const double c = std::cos(heading), s = std::sin(heading);
  const auto wheel = [&](double ahead, double left) {
    return height(x + ahead * c - left * s, y + ahead * s + left * c);
  };
  const double fl = wheel(kForward, kSide), fr = wheel(kForward, -kSide), bl = wheel(-kForward, kSide),
               br = wheel(-kForward, -kSide);
  return std::hypot(std::atan2((fl + fr - bl - br) / 2, 2 * kForward), std::atan2((fl + bl - fr - br) / 2, 2 * kSide));
}

/// The rover's.
inline double tilt_at(double x, double y, double heading) { return tilt_over(ground_at, x, y, heading); }

}  // namespace dala
